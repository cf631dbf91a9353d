#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace infuse::rosbag {

/// A topic of a database.
struct DatabaseTopic {
  std::string name;
  std::string type;      ///< "sensor_msgs/msg/Imu"
  std::string encoding;  ///< "cdr"
};

/// One message. Its data is valid until the next message is read, its topic as long as the reader.
struct DatabaseMessage {
  const DatabaseTopic* topic = nullptr;
  Stamp time;  ///< when it was recorded
  std::span<const uint8_t> data;
};

/// Reads a database of rosbag2 (.db3, SQLite) in the order in which it was written. The work for a
/// message and its size (256 MiB) are bounded, whatever the database states. Messages that rosbag2
/// has compressed one by one are not read.
class DatabaseReader {
 public:
  /// Opens a file. Fails if it is not a database with the tables of rosbag2.
  static Result<DatabaseReader> open(const std::filesystem::path& path);

  /// True if a file begins like a database.
  static bool is_database(std::span<const uint8_t> bytes);

  /// Reads the next message. Returns false at the end, or where the database is damaged.
  bool next(DatabaseMessage& message);

  /// Appends what was wrong with the file so far, for display.
  void append_notes(std::vector<Error>& notes) const;

 private:
  struct CloseDatabase {
    void operator()(sqlite3* database) const;
  };
  struct FinishStatement {
    void operator()(sqlite3_stmt* statement) const;
  };
  using Statement = std::unique_ptr<sqlite3_stmt, FinishStatement>;

  explicit DatabaseReader(std::string name) : name_(std::move(name)) {}
  Result<void> open_database(const std::filesystem::path& path);
  Result<void> check_tables();
  Result<void> read_topics();
  Result<Statement> prepare(const char* text);
  int step(sqlite3_stmt* statement);

  std::string name_;
  std::unique_ptr<sqlite3, CloseDatabase> database_;
  std::unique_ptr<int> work_;  ///< of the present step, counted by SQLite
  Statement messages_;
  std::map<int64_t, DatabaseTopic> topics_;
  uint64_t without_topic_ = 0;
  std::vector<Error> notes_;
};

}  // namespace infuse::rosbag
