#include "drivers/rosbag/database_reader.hpp"

#include <sqlite3.h>

#include <cstring>
#include <string_view>

namespace infuse::rosbag {
namespace {

constexpr std::string_view kDatabaseMagic("SQLite format 3\0", 16);
constexpr int kMaxMessageBytes = 256 << 20;
constexpr size_t kMaxTopics = 10'000;
constexpr int kMaxWork = 1000;  // calls of `count_work`, one per kWorkSteps instructions
constexpr int kWorkSteps = 10'000;

/// Ends a statement that works too long for one row.
int count_work(void* work) { return ++*static_cast<int*>(work) > kMaxWork ? 1 : 0; }

std::string text_of(sqlite3_stmt* statement, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
  const int bytes = sqlite3_column_bytes(statement, column);
  return text == nullptr ? std::string() : std::string(text, static_cast<size_t>(bytes));
}

}  // namespace

void DatabaseReader::CloseDatabase::operator()(sqlite3* database) const { sqlite3_close(database); }

void DatabaseReader::FinishStatement::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

bool DatabaseReader::is_database(std::span<const uint8_t> bytes) {
  return bytes.size() >= kDatabaseMagic.size() &&
         std::memcmp(bytes.data(), kDatabaseMagic.data(), kDatabaseMagic.size()) == 0;
}

Result<DatabaseReader> DatabaseReader::open(const std::filesystem::path& path) {
  DatabaseReader reader(path.string());
  auto opened =
      reader.open_database(path).and_then([&] { return reader.check_tables(); }).and_then([&] {
        return reader.read_topics();
      });
  if (!opened) return tl::unexpected(opened.error());
  auto messages = reader.prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY id");
  if (!messages) return tl::unexpected(messages.error());
  reader.messages_ = std::move(*messages);
  return reader;
}

Result<void> DatabaseReader::open_database(const std::filesystem::path& path) {
  sqlite3* database = nullptr;
  const int status =
      sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
  database_.reset(database);
  if (status != SQLITE_OK) return fail("cannot be opened as a database", name_);
  // The file is not ours: no functions of its schema, no large values, no endless work.
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, kMaxMessageBytes);
  work_ = std::make_unique<int>(0);
  sqlite3_progress_handler(database, kWorkSteps, count_work, work_.get());
  return {};
}

Result<DatabaseReader::Statement> DatabaseReader::prepare(const char* text) {
  *work_ = 0;
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_.get(), text, -1, &statement, nullptr) != SQLITE_OK) {
    return fail(std::string("is not a recording of rosbag2: ") + sqlite3_errmsg(database_.get()),
                name_);
  }
  return Statement(statement);
}

int DatabaseReader::step(sqlite3_stmt* statement) {
  *work_ = 0;
  return sqlite3_step(statement);
}

// Views and virtual tables run what the file says.
Result<void> DatabaseReader::check_tables() {
  auto count = prepare(
      "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages') "
      "AND sql LIKE 'CREATE TABLE %'");
  if (!count) return tl::unexpected(count.error());
  if (step(count->get()) != SQLITE_ROW || sqlite3_column_int(count->get(), 0) != 2)
    return fail("has no tables of topics and messages", name_, "expected a recording of rosbag2");
  return {};
}

Result<void> DatabaseReader::read_topics() {
  auto rows = prepare("SELECT id, name, type, serialization_format FROM topics");
  if (!rows) return tl::unexpected(rows.error());
  while (topics_.size() < kMaxTopics && step(rows->get()) == SQLITE_ROW) {
    topics_[sqlite3_column_int64(rows->get(), 0)] = {
        text_of(rows->get(), 1), text_of(rows->get(), 2), text_of(rows->get(), 3)};
  }
  return {};
}

bool DatabaseReader::next(DatabaseMessage& message) {
  while (messages_) {
    const int status = step(messages_.get());
    if (status != SQLITE_ROW) {
      if (status != SQLITE_DONE) {
        notes_.push_back({std::string("is damaged: ") + sqlite3_errmsg(database_.get()), name_,
                          "the messages before it are read"});
      }
      messages_.reset();
      return false;
    }
    const auto topic = topics_.find(sqlite3_column_int64(messages_.get(), 0));
    if (topic == topics_.end()) {
      ++without_topic_;
      continue;
    }
    message.topic = &topic->second;
    message.time = Stamp::from_ns(sqlite3_column_int64(messages_.get(), 1));
    const auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(messages_.get(), 2));
    const int bytes = sqlite3_column_bytes(messages_.get(), 2);
    message.data = {data, data == nullptr ? 0 : static_cast<size_t>(bytes)};
    return true;
  }
  return false;
}

void DatabaseReader::append_notes(std::vector<Error>& notes) const {
  notes.insert(notes.end(), notes_.begin(), notes_.end());
  if (without_topic_ > 0) {
    notes.push_back(
        {std::to_string(without_topic_) + " messages of unknown topics are skipped", name_, ""});
  }
}

}  // namespace infuse::rosbag
