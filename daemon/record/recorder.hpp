#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "daemon/config/record_settings.hpp"
#include "daemon/record/record_tap.hpp"
#include "daemon/record/recording.hpp"
#include "drivers/receive/time_base.hpp"

namespace infuse::daemon {

/// Writes recordings, one at a time, on a thread of its own. What was heard last waits for it in
/// memory, so that a recording can begin in the past; where it does not keep up, the oldest of that
/// is lost, and counted.
class Recorder {
 public:
  Recorder(const RecordSettings& settings, std::filesystem::path directory,
           const receive::TimeBase& base);
  ~Recorder() { finish(); }

  /// Where the io thread puts what it reads.
  RecordTap& tap() { return tap_; }

  // --- of any other thread ---

  /// Writes this recording from now on, and ends the one before.
  void begin(Recording recording);

  /// Ends the recording with the records of this moment; nothing where there is none.
  void end_at(Stamp until);

  /// How the last recording stands; nothing where there was none.
  std::optional<RecordReport> report() const;

  /// A recording is being made.
  bool is_recording() const;

  /// Writes what has come, and ends. The io thread has ended already.
  void finish();

 private:
  void run(std::stop_token stop);
  bool process_requests(std::stop_token& stop);
  void write_chunks(Duration timeout);
  void update_report();

  const RecordSettings settings_;
  const std::filesystem::path directory_;
  const receive::TimeBase base_;
  RecordRing ring_;
  RecordRing::Reader reader_;
  RecordTap tap_;

  // Of the thread:
  std::optional<Recording> recording_;
  RecordParser parser_;

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable_any requested_;
  std::optional<Recording> next_;
  std::optional<Stamp> until_;
  std::optional<RecordReport> report_;

  std::jthread thread_;
};

/// Removes the oldest drives of alerts in a folder beyond the newest `keep`; drives of one
/// recording count as one.
void remove_old_alerts(const std::filesystem::path& directory, size_t keep);

/// What the names of drives of alerts begin with.
inline constexpr const char* kAlertPrefix = "alert-";

}  // namespace infuse::daemon
