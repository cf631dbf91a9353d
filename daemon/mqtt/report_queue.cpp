#include "daemon/mqtt/report_queue.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <system_error>

namespace infuse::daemon {
namespace {

// Some bytes of a file are its own: pages that are not full, the index, the log before a
// checkpoint.
constexpr uint64_t kFileOverhead = 2;  // times the messages at most
constexpr int kPageBytes = 4096;

constexpr int kVersion = 1;  // of the tables; 0 is an empty file, or that of 0.1.0
constexpr const char* kSchema =
    "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA journal_size_limit=1048576;"
    "CREATE TABLE IF NOT EXISTS reports(id INTEGER PRIMARY KEY AUTOINCREMENT, importance INTEGER "
    "NOT NULL,"
    " topic TEXT NOT NULL, payload BLOB NOT NULL, retain INTEGER NOT NULL);"
    "CREATE INDEX IF NOT EXISTS by_importance ON reports(importance, id);";

uint64_t size_of(const QueuedReport& report) { return report.topic.size() + report.payload.size(); }

std::string column_bytes(sqlite3_stmt* statement, int column) {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement, column));
  const int count = sqlite3_column_bytes(statement, column);
  return bytes == nullptr ? std::string() : std::string(bytes, static_cast<size_t>(count));
}

}  // namespace

void ReportQueue::CloseDatabase::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

void ReportQueue::FinishStatement::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Result<ReportQueue> ReportQueue::open(const std::filesystem::path& path, uint64_t max_bytes) {
  ReportQueue queue(max_bytes);
  if (path.empty()) {
    if (auto opened = queue.open_file(":memory:"); !opened) return tl::unexpected(opened.error());
    return queue;
  }
  auto opened = queue.open_file(path.string());
  if (opened) return queue;
  // Damaged, or from something else: it is kept for who wants to know, and a new one is begun.
  ReportQueue fresh(max_bytes);
  const std::string why = opened.error().message();
  queue = ReportQueue(max_bytes);  // closes the file
  std::error_code failed;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    const std::filesystem::path file = path.string() + suffix;
    if (!std::filesystem::exists(file, failed)) continue;
    std::filesystem::rename(file, path.string() + ".damaged" + suffix, failed);
  }
  opened = fresh.open_file(path.string());
  if (!opened) return tl::unexpected(opened.error());
  fresh.damage_ = why + "; kept as " + path.string() + ".damaged";
  return fresh;
}

Result<void> ReportQueue::open_file(const std::string& path) {
  sqlite3* database = nullptr;
  const int status =
      sqlite3_open_v2(path.c_str(), &database,
                      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  database_.reset(database);
  if (status != SQLITE_OK)
    return fail("cannot be opened: " + std::string(sqlite3_errstr(status)), path);
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  const int version = read_version();
  if (version > kVersion) return fail("was written by a newer version of infuse", path);
  if (auto done = execute(kSchema); !done) return fail(done.error().what, path);
  // Not on a full disk: then the next start states it.
  if (version < kVersion) {
    static_cast<void>(execute(("PRAGMA user_version=" + std::to_string(kVersion)).c_str()));
  }
  const auto pages = static_cast<unsigned long long>(kFileOverhead * max_bytes_ / kPageBytes + 64);
  if (auto done = execute(("PRAGMA max_page_count=" + std::to_string(pages)).c_str()); !done) {
    return fail(done.error().what, path);
  }
  insert_ = prepare("INSERT INTO reports(importance, topic, payload, retain) VALUES(?, ?, ?, ?)");
  next_ = prepare(
      "SELECT id, importance, topic, payload, retain FROM reports WHERE id > ? ORDER BY id LIMIT "
      "1");
  size_of_ =
      prepare("SELECT length(CAST(topic AS BLOB)) + length(payload) FROM reports WHERE id = ?");
  least_ = prepare("SELECT id FROM reports ORDER BY importance, id LIMIT 1");
  delete_ = prepare("DELETE FROM reports WHERE id = ?");
  const Statement total = prepare(
      "SELECT count(*), coalesce(sum(length(CAST(topic AS BLOB)) + length(payload)), 0)"
      " FROM reports");
  if (!insert_ || !next_ || !size_of_ || !least_ || !delete_ || !total ||
      sqlite3_step(total.get()) != SQLITE_ROW) {
    return fail(std::string("is not a queue of reports: ") + sqlite3_errmsg(database), path);
  }
  messages_ = static_cast<uint64_t>(sqlite3_column_int64(total.get(), 0));
  bytes_ = static_cast<uint64_t>(sqlite3_column_int64(total.get(), 1));
  return {};
}

int ReportQueue::read_version() {
  const Statement version = prepare("PRAGMA user_version");
  if (!version || sqlite3_step(version.get()) != SQLITE_ROW) return 0;
  return sqlite3_column_int(version.get(), 0);
}

Result<void> ReportQueue::execute(const char* text) {
  if (sqlite3_exec(database_.get(), text, nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return fail(std::string("is not a queue of reports: ") + sqlite3_errmsg(database_.get()));
}

ReportQueue::Statement ReportQueue::prepare(const char* text) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database_.get(), text, -1, &statement, nullptr);
  return Statement(statement);
}

bool ReportQueue::insert(const QueuedReport& report) {
  sqlite3_stmt* row = insert_.get();
  sqlite3_bind_int(row, 1, report.importance);
  sqlite3_bind_text64(row, 2, report.topic.data(), report.topic.size(), SQLITE_STATIC, SQLITE_UTF8);
  sqlite3_bind_blob64(row, 3, report.payload.data(), report.payload.size(), SQLITE_STATIC);
  sqlite3_bind_int(row, 4, report.retain ? 1 : 0);
  const bool inserted = sqlite3_step(row) == SQLITE_DONE;
  sqlite3_reset(row);
  sqlite3_clear_bindings(row);
  if (!inserted) return false;
  ++messages_;
  bytes_ += size_of(report);
  return true;
}

Result<void> ReportQueue::add(const QueuedReport& report) {
  constexpr int kMaxDropsPerAdd = 64;
  if (size_of(report) > max_bytes_) {
    ++dropped_;
    return fail("a report of " + std::to_string(size_of(report)) + " bytes exceeds queue_mb");
  }
  while (bytes_ + size_of(report) > max_bytes_ && drop_least_important()) {
  }
  for (int drops = 0; drops <= kMaxDropsPerAdd; ++drops) {
    if (insert(report)) return {};
    if (!drop_least_important()) break;
  }
  ++dropped_;
  return fail(std::string("a report cannot be queued: ") + sqlite3_errmsg(database_.get()));
}

bool ReportQueue::drop_least_important() {
  const bool any = sqlite3_step(least_.get()) == SQLITE_ROW;
  const int64_t id = any ? sqlite3_column_int64(least_.get(), 0) : 0;
  sqlite3_reset(least_.get());
  const uint64_t before = messages_;
  if (any) remove(id);
  if (messages_ == before) return false;
  ++dropped_;
  return true;
}

std::optional<QueuedReport> ReportQueue::next_after(int64_t id) {
  sqlite3_bind_int64(next_.get(), 1, id);
  std::optional<QueuedReport> report;
  if (sqlite3_step(next_.get()) == SQLITE_ROW) {
    report = QueuedReport{.id = sqlite3_column_int64(next_.get(), 0),
                          .importance = sqlite3_column_int(next_.get(), 1),
                          .topic = column_bytes(next_.get(), 2),
                          .payload = column_bytes(next_.get(), 3),
                          .retain = sqlite3_column_int(next_.get(), 4) != 0};
  }
  sqlite3_reset(next_.get());
  return report;
}

void ReportQueue::remove(int64_t id) {
  sqlite3_bind_int64(size_of_.get(), 1, id);
  const bool exists = sqlite3_step(size_of_.get()) == SQLITE_ROW;
  const auto bytes = static_cast<uint64_t>(exists ? sqlite3_column_int64(size_of_.get(), 0) : 0);
  sqlite3_reset(size_of_.get());
  if (exists) remove_row(id, bytes);
}

void ReportQueue::remove_row(int64_t id, uint64_t bytes) {
  sqlite3_bind_int64(delete_.get(), 1, id);
  const bool removed = sqlite3_step(delete_.get()) == SQLITE_DONE;
  sqlite3_reset(delete_.get());
  if (!removed) return;
  --messages_;
  bytes_ -= std::min(bytes_, bytes);
}

}  // namespace infuse::daemon
