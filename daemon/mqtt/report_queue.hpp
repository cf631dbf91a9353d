#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "drivers/measurement/error.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace infuse::daemon {

/// A message for the broker.
struct QueuedReport {
  int64_t id = 0;      ///< rises with every message; kept over restarts
  int importance = 0;  ///< of a full queue the least important are dropped first
  std::string topic;
  std::string payload;
  bool retain = false;
};

/// Messages that wait for the broker, in order, in a file that outlives the process and has a
/// bounded size. Where it is full, the oldest of the least important are dropped and counted.
class ReportQueue {
 public:
  /// Opens or creates the file; an empty path keeps the messages in memory. A file that is damaged
  /// is set aside as PATH.damaged. `max_bytes`: of topics and payloads together.
  static Result<ReportQueue> open(const std::filesystem::path& path, uint64_t max_bytes);

  /// Adds a message (its `id` is ignored); drops others where needed. Fails if the disk is full and
  /// nothing was left to drop; the message is counted as dropped then.
  Result<void> add(const QueuedReport& report);

  /// Returns the first message after `id`, or nothing.
  std::optional<QueuedReport> next_after(int64_t id);

  /// Removes a message that the broker has.
  void remove(int64_t id);

  uint64_t messages() const { return messages_; }
  uint64_t bytes() const { return bytes_; }
  uint64_t max_bytes() const { return max_bytes_; }
  uint64_t dropped() const { return dropped_; }

  /// What was wrong with the file at the start, or an empty text.
  const std::string& damage() const { return damage_; }

 private:
  struct CloseDatabase {
    void operator()(sqlite3* database) const;
  };
  struct FinishStatement {
    void operator()(sqlite3_stmt* statement) const;
  };
  using Statement = std::unique_ptr<sqlite3_stmt, FinishStatement>;

  explicit ReportQueue(uint64_t max_bytes) : max_bytes_(max_bytes) {}
  Result<void> open_file(const std::string& path);
  Result<void> execute(const char* text);
  int read_version();
  Statement prepare(const char* text);
  bool insert(const QueuedReport& report);
  bool drop_least_important();
  void remove_row(int64_t id, uint64_t bytes);

  uint64_t max_bytes_;
  std::unique_ptr<sqlite3, CloseDatabase> database_;
  Statement insert_, next_, size_of_, least_, delete_;
  uint64_t messages_ = 0, bytes_ = 0, dropped_ = 0;
  std::string damage_;
};

}  // namespace infuse::daemon
