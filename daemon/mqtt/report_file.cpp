#include "daemon/mqtt/report_file.hpp"

#include <sqlite3.h>

namespace infuse::daemon {
namespace {

constexpr int kVersion = 1;  // of the tables; 0 is an empty file, or that of 0.1.0
constexpr const char* kSchema =
    "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA journal_size_limit=1048576;"
    "CREATE TABLE IF NOT EXISTS reports(id INTEGER PRIMARY KEY AUTOINCREMENT, importance INTEGER "
    "NOT NULL,"
    " topic TEXT NOT NULL, payload BLOB NOT NULL, retain INTEGER NOT NULL);"
    "CREATE INDEX IF NOT EXISTS by_importance ON reports(importance, id);";

std::string column_bytes(sqlite3_stmt* statement, int column) {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement, column));
  const int count = sqlite3_column_bytes(statement, column);
  return bytes == nullptr ? std::string() : std::string(bytes, static_cast<size_t>(count));
}

/// True if the file itself is wrong, and not its disk, its folder or this process.
bool is_damage(int status) {
  const int code = status & 0xff;  // the primary code (sqlite.org/rescode.html)
  return code == SQLITE_CORRUPT || code == SQLITE_NOTADB || code == SQLITE_ERROR ||
         code == SQLITE_SCHEMA || code == SQLITE_FORMAT || code == SQLITE_MISMATCH;
}

}  // namespace

void ReportFile::CloseDatabase::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

void ReportFile::FinishStatement::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

tl::expected<ReportFile, ReportFile::Failure> ReportFile::open(const std::filesystem::path& path) {
  ReportFile file;
  sqlite3* database = nullptr;
  const int status =
      sqlite3_open_v2(path.c_str(), &database,
                      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  file.database_.reset(database);
  const auto failed = [&](const std::string& what, bool damaged) {
    return tl::unexpected(Failure{path.string() + ": " + what, damaged});
  };
  if (status != SQLITE_OK) {
    return failed(std::string("cannot be opened: ") + sqlite3_errstr(status), is_damage(status));
  }
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  if (file.read_number("PRAGMA user_version") > kVersion) {
    return failed("was written by a newer version of infuse", true);
  }
  if (!file.set_up()) {
    const bool damaged = is_damage(sqlite3_extended_errcode(database));
    return failed((damaged ? "is not a queue of reports: " : "cannot be used: ") +
                      std::string(sqlite3_errmsg(database)),
                  damaged);
  }
  return file;
}

bool ReportFile::execute(const std::string& text) {
  return sqlite3_exec(database_.get(), text.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK;
}

bool ReportFile::set_up() {
  const bool done = execute(kSchema) && execute("PRAGMA user_version=" + std::to_string(kVersion));
  if (!done) return false;
  insert_ = prepare("INSERT INTO reports(importance, topic, payload, retain) VALUES(?, ?, ?, ?)");
  next_ = prepare(
      "SELECT id, importance, topic, payload, retain FROM reports WHERE id > ? ORDER BY id LIMIT "
      "1");
  size_of_ =
      prepare("SELECT length(CAST(topic AS BLOB)) + length(payload) FROM reports WHERE id = ?");
  least_ = prepare("SELECT id FROM reports ORDER BY importance, id LIMIT 1");
  delete_ = prepare("DELETE FROM reports WHERE id = ?");
  stop_retaining_ = prepare("UPDATE reports SET retain = 0 WHERE topic = ?");
  return insert_ && next_ && size_of_ && least_ && delete_ && stop_retaining_;
}

int64_t ReportFile::read_number(const char* text) {
  const Statement number = prepare(text);
  if (!number || sqlite3_step(number.get()) != SQLITE_ROW) return 0;
  return sqlite3_column_int64(number.get(), 0);
}

std::pair<uint64_t, uint64_t> ReportFile::totals() {
  const int64_t count = read_number("SELECT count(*) FROM reports");
  const int64_t bytes = read_number(
      "SELECT coalesce(sum(length(CAST(topic AS BLOB)) + length(payload)), 0) FROM reports");
  return {static_cast<uint64_t>(count), static_cast<uint64_t>(bytes)};
}

int64_t ReportFile::last_id() {
  return read_number("SELECT seq FROM sqlite_sequence WHERE name = 'reports'");
}

ReportFile::Statement ReportFile::prepare(const char* text) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database_.get(), text, -1, &statement, nullptr);
  return Statement(statement);
}

tl::unexpected<Error> ReportFile::failure() {
  return fail(
      std::string("reports for the broker cannot be kept: ") + sqlite3_errmsg(database_.get()),
      sqlite3_db_filename(database_.get(), "main"));
}

Result<void> ReportFile::run(sqlite3_stmt* statement) {
  Result<void> done;
  if (sqlite3_step(statement) != SQLITE_DONE) done = failure();
  sqlite3_reset(statement);
  sqlite3_clear_bindings(statement);
  return done;
}

/// False if there is no row. The caller resets the statement.
Result<bool> ReportFile::find_row(sqlite3_stmt* statement) {
  const int status = sqlite3_step(statement);
  if (status != SQLITE_ROW && status != SQLITE_DONE) return failure();
  return status == SQLITE_ROW;
}

Result<void> ReportFile::change_at_once(const std::function<Result<void>()>& change) {
  if (!execute("BEGIN IMMEDIATE")) return failure();
  Result<void> changed = change();
  if (changed && !execute("COMMIT")) changed = failure();
  if (!changed) execute("ROLLBACK");
  return changed;
}

Result<int64_t> ReportFile::add(const QueuedReport& report) {
  sqlite3_stmt* row = insert_.get();
  sqlite3_bind_int(row, 1, report.importance);
  sqlite3_bind_text64(row, 2, report.topic.data(), report.topic.size(), SQLITE_STATIC, SQLITE_UTF8);
  sqlite3_bind_blob64(row, 3, report.payload.data(), report.payload.size(), SQLITE_STATIC);
  sqlite3_bind_int(row, 4, report.retain ? 1 : 0);
  return run(row).map([this] { return int64_t{sqlite3_last_insert_rowid(database_.get())}; });
}

Result<std::optional<QueuedReport>> ReportFile::next_after(int64_t id) {
  sqlite3_stmt* row = next_.get();
  sqlite3_bind_int64(row, 1, id);
  auto next = find_row(row).map([row](bool found) -> std::optional<QueuedReport> {
    if (!found) return std::nullopt;
    return QueuedReport{.id = sqlite3_column_int64(row, 0),
                        .importance = sqlite3_column_int(row, 1),
                        .topic = column_bytes(row, 2),
                        .payload = column_bytes(row, 3),
                        .retain = sqlite3_column_int(row, 4) != 0};
  });
  sqlite3_reset(row);
  return next;
}

Result<uint64_t> ReportFile::remove(int64_t id) {
  sqlite3_bind_int64(size_of_.get(), 1, id);
  const auto exists = find_row(size_of_.get());
  const auto bytes =
      static_cast<uint64_t>(exists.value_or(false) ? sqlite3_column_int64(size_of_.get(), 0) : 0);
  sqlite3_reset(size_of_.get());
  if (!exists) return tl::unexpected(exists.error());
  if (!*exists) return 0;
  sqlite3_bind_int64(delete_.get(), 1, id);
  return run(delete_.get()).map([bytes] { return bytes; });
}

Result<void> ReportFile::stop_retaining(const std::string& topic) {
  sqlite3_bind_text64(stop_retaining_.get(), 1, topic.data(), topic.size(), SQLITE_STATIC,
                      SQLITE_UTF8);
  return run(stop_retaining_.get());
}

Result<std::optional<int64_t>> ReportFile::lowest_importance() {
  auto least = find_row(least_.get()).map([this](bool found) -> std::optional<int64_t> {
    if (!found) return std::nullopt;
    return sqlite3_column_int64(least_.get(), 0);
  });
  sqlite3_reset(least_.get());
  return least;
}

}  // namespace infuse::daemon
