#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "daemon/config/record_settings.hpp"
#include "daemon/record/record_tap.hpp"
#include "daemon/record/recording.hpp"
#include "daemon/record/recordings_budget.hpp"

namespace infuse::daemon {

/// Who writes recordings.
enum class RecorderThread : uint8_t {
  kOwn,   ///< a thread of the recorder
  kNone,  ///< who calls `work`: a simulation
};

/// Writes recordings, one at a time, on a thread of its own. The latest sensor data is kept in
/// memory, so that a recording can begin in the past; if the thread falls behind, the oldest data
/// is lost and counted.
class Recorder {
 public:
  /// `now`: the present; called by any thread.
  Recorder(const RecordSettings& settings, std::filesystem::path directory,
           std::function<Stamp()> now, RecorderThread thread = RecorderThread::kOwn);
  ~Recorder() {
    if (thread_.joinable()) finish();
  }

  /// Input of the io thread.
  RecordTap& tap() { return tap_; }

  // --- for any other thread ---

  /// Starts this recording and ends the previous one.
  void begin(Recording recording);

  /// Ends the recording at stamp `until`; does nothing if none is running.
  void end_at(Stamp until);

  /// State of the last recording; nothing if there was none.
  std::optional<RecordReport> report() const;

  /// True while a recording is being written.
  bool is_recording() const;

  /// Without a thread: writes what has come since the last call.
  void work();

  /// Writes the remaining data and ends the thread. The io thread must have ended before.
  void finish();

 private:
  void run(std::stop_token stop);
  bool process_requests(std::stop_token& stop);
  void apply_requests(std::unique_lock<std::mutex>& lock);
  void write_rest();
  void write_chunks(Duration timeout);
  void update_report();

  const RecordSettings settings_;
  const std::filesystem::path directory_;
  const std::function<Stamp()> now_;
  RecordingsBudget budget_;  // used by the recorder's thread only
  RecordRing ring_;
  RecordRing::Reader reader_;
  RecordTap tap_;

  // Used by the recorder's thread only:
  std::optional<Recording> recording_;
  RecordParser parser_;

  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable_any requested_;
  std::optional<Recording> next_;
  std::optional<Stamp> until_;
  std::optional<RecordReport> report_;

  std::jthread thread_;
};

}  // namespace infuse::daemon
