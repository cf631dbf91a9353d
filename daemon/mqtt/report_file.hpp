#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "daemon/mqtt/queued_report.hpp"
#include "drivers/measurement/error.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace infuse::daemon {

/// Messages in a database file that outlives the process.
class ReportFile {
 public:
  /// Why a file cannot be used.
  struct Failure {
    std::string what;
    bool damaged = false;  ///< of the file itself, or it is something else; false: of its disk
  };

  /// Opens or creates the file. Its messages stay as they are on a failure.
  static tl::expected<ReportFile, Failure> open(const std::filesystem::path& path);

  /// Adds a message (its `id` is ignored) and returns its number, larger than that of every earlier
  /// one. Fails where the disk does, as all below.
  Result<int64_t> add(const QueuedReport& report);

  /// Returns the first message after `id`, or nothing.
  Result<std::optional<QueuedReport>> next_after(int64_t id);

  /// Removes a message, if it is there; returns its bytes.
  Result<uint64_t> remove(int64_t id);

  /// Makes all changes of `change`, or none if it or the disk fails.
  Result<void> change_at_once(const std::function<Result<void>()>& change);

  /// Leaves the broker's retained message of a topic as it is: those that wait are older.
  Result<void> stop_retaining(const std::string& topic);

  /// Number of the oldest of the least important messages; nothing if there is none.
  Result<std::optional<int64_t>> lowest_importance();

  /// Number and bytes of all messages.
  std::pair<uint64_t, uint64_t> totals();

  /// Largest number that a message has had.
  int64_t last_id();

 private:
  struct CloseDatabase {
    void operator()(sqlite3* database) const;
  };
  struct FinishStatement {
    void operator()(sqlite3_stmt* statement) const;
  };
  using Statement = std::unique_ptr<sqlite3_stmt, FinishStatement>;

  ReportFile() = default;
  bool execute(const std::string& text);
  bool set_up();
  int64_t read_number(const char* text);
  Statement prepare(const char* text);
  Result<void> run(sqlite3_stmt* statement);
  Result<bool> find_row(sqlite3_stmt* statement);
  tl::unexpected<Error> failure();

  std::unique_ptr<sqlite3, CloseDatabase> database_;
  Statement insert_, next_, size_of_, least_, delete_, stop_retaining_;
};

}  // namespace infuse::daemon
