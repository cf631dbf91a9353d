#include "drivers/rosbag/database_reader.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <random>

#include "tests/scratch_folder.hpp"

namespace infuse::rosbag {
namespace {

/// Runs SQL on a new database.
void make_database(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  char* error = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK)
      << (error == nullptr ? "" : error);
  sqlite3_close(database);
}

// As rosbag2_storage_default_plugins of ROS 2 Humble creates them.
constexpr const char* kTables =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
    "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER "
    "NOT NULL, data BLOB NOT NULL);"
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC);";

std::string make_rows(int messages) {
  std::string sql = std::string("BEGIN;") + kTables;
  sql +=
      "INSERT INTO topics VALUES(1, '/imu', 'sensor_msgs/msg/Imu', 'cdr', '');"
      "INSERT INTO topics VALUES(2, '/fix', 'sensor_msgs/msg/NavSatFix', 'cdr', '');";
  for (int k = 0; k < messages; ++k) {
    sql += "INSERT INTO messages VALUES(NULL, " + std::to_string(1 + k % 2) + ", " +
           std::to_string(1'700'000'000'000'000'000 + k) + ", x'0001000" + std::to_string(k % 10) +
           "');";
  }
  return sql + "COMMIT;";
}

TEST(DatabaseReader, MessagesAreReadInTheirOrder) {
  const ScratchFolder folder;
  make_database(folder / "a.db3", make_rows(9));
  auto reader = DatabaseReader::open(folder / "a.db3");
  ASSERT_TRUE(reader) << reader.error().message();
  DatabaseMessage message;
  for (int k = 0; k < 9; ++k) {
    ASSERT_TRUE(reader->next(message));
    EXPECT_EQ(message.topic->name, k % 2 == 0 ? "/imu" : "/fix");
    EXPECT_EQ(message.topic->encoding, "cdr");
    EXPECT_EQ(message.time.ns(), 1'700'000'000'000'000'000 + k);
    ASSERT_EQ(message.data.size(), 4u);
    EXPECT_EQ(message.data[3], k);
  }
  EXPECT_FALSE(reader->next(message));
  std::vector<Error> notes;
  reader->append_notes(notes);
  EXPECT_TRUE(notes.empty());
}

TEST(DatabaseReader, OtherDatabasesAreErrors) {
  const ScratchFolder folder;
  EXPECT_FALSE(DatabaseReader::open(folder / "none.db3"));
  folder.write("text.db3", "no database");
  EXPECT_FALSE(DatabaseReader::open(folder / "text.db3"));
  make_database(folder / "other.db3", "CREATE TABLE a(b);");
  EXPECT_FALSE(DatabaseReader::open(folder / "other.db3"));
  make_database(folder / "columns.db3", "CREATE TABLE topics(a); CREATE TABLE messages(b);");
  EXPECT_FALSE(DatabaseReader::open(folder / "columns.db3"));
}

// A view may be a query without end.
TEST(DatabaseReader, ViewsAreRefused) {
  const ScratchFolder folder;
  make_database(folder / "view.db3",
                "CREATE TABLE topics(id, name, type, serialization_format);"
                "CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 "
                "FROM n) SELECT id, 1 AS topic_id, 1 AS timestamp, 1 AS data FROM n;");
  EXPECT_FALSE(DatabaseReader::open(folder / "view.db3"));
}

TEST(DatabaseReader, MutatedDatabasesNeitherCrashNorHang) {
  const ScratchFolder folder;
  make_database(folder / "sound.db3", make_rows(60));
  const std::string sound = folder.read("sound.db3");
  std::mt19937 random(4);
  size_t messages = 0;
  for (int k = 0; k < 200; ++k) {
    std::string bytes = sound;
    for (size_t n = 1 + random() % 4; n > 0; --n)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    folder.write("a.db3", bytes);
    auto reader = DatabaseReader::open(folder / "a.db3");
    DatabaseMessage message;
    size_t read = 0;
    while (reader && read < 10'000 && reader->next(message)) ++read;
    ASSERT_LT(read, 10'000u);
    messages += read;
  }
  EXPECT_GT(messages, 2000u);  // what can be read is read
}

}  // namespace
}  // namespace infuse::rosbag
