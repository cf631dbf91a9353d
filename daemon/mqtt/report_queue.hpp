#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "daemon/mqtt/queued_report.hpp"
#include "daemon/mqtt/report_file.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Messages that wait for the broker, in order and of bounded size. They lie in a file that
/// outlives the process. While its disk is full, read-only or broken they wait in memory, and what
/// is in the file stays there. Of a full queue the oldest of the least important are dropped and
/// counted.
class ReportQueue {
 public:
  /// An empty path keeps the messages in memory. A file that is damaged is set aside as
  /// PATH.damaged, or PATH.damaged.N: none is overwritten. `max_bytes`: of topics and payloads
  /// together.
  ReportQueue(std::filesystem::path path, uint64_t max_bytes);

  /// Adds a message (its `id` is ignored); drops others where needed. Fails if it alone exceeds the
  /// queue; it is counted as dropped then.
  Result<void> add(const QueuedReport& report);

  /// Returns the first message after `id`, or nothing.
  std::optional<QueuedReport> next_after(int64_t id);

  /// Removes a message that the broker has.
  void remove(int64_t id);

  /// Uses the file again if it can be: what waits in memory follows what waits there, and has other
  /// numbers then. Returns true if so.
  bool try_file();

  /// Of the messages that can be published at present.
  uint64_t messages() const { return messages_; }
  uint64_t bytes() const { return bytes_; }
  uint64_t max_bytes() const { return max_bytes_; }
  uint64_t dropped() const { return dropped_; }

  /// What was wrong with the file at the start, or an empty text.
  const std::string& damage() const { return damage_; }

  /// Why messages wait in memory although there is a path; an empty text if they do not.
  const std::string& disk_problem() const { return disk_problem_; }

 private:
  bool open_file();
  void leave_file(const Error& why);
  Result<void> move_to_file(ReportFile& file);
  void make_room(uint64_t bytes);
  bool drop_lowest_importance();
  void remove_from_memory(int64_t id);

  std::filesystem::path path_;
  uint64_t max_bytes_;
  std::optional<ReportFile> file_;
  int64_t last_id_ = 0;
  // While there is no file:
  std::map<int64_t, QueuedReport> memory_;
  std::set<std::pair<int, int64_t>> by_importance_;  // of those in memory
  std::set<std::string> newer_topics_;               // of retained ones that were in memory
  std::vector<int64_t> published_;                   // of the file
  uint64_t messages_ = 0, bytes_ = 0, dropped_ = 0;
  std::string damage_, disk_problem_;
};

}  // namespace infuse::daemon
