#include "daemon/process/logging.hpp"

#define SD_JOURNAL_SUPPRESS_LOCATION
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/systemd_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <systemd/sd-journal.h>
#include <unistd.h>

#include <cstdlib>
#include <vector>

namespace infuse::daemon {
namespace {

/// True if standard error is the journal: systemd puts its device and inode into $JOURNAL_STREAM.
bool logs_to_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat about {};
  if (stream == nullptr || fstat(STDERR_FILENO, &about) != 0) return false;
  return std::to_string(about.st_dev) + ":" + std::to_string(about.st_ino) == stream;
}

/// Returns the priority of syslog(3).
int syslog_priority(spdlog::level::level_enum level) {
  if (level >= spdlog::level::err) return LOG_ERR;
  return level == spdlog::level::warn ? LOG_WARNING : LOG_INFO;
}

}  // namespace

void set_up_logging(const std::string& name) {
  spdlog::set_default_logger(logs_to_journal() ? spdlog::systemd_logger_mt(name, name)
                                               : spdlog::stderr_color_mt(name));
}

void log_line(spdlog::level::level_enum level, const std::string& line,
              std::span<const LogField> fields) {
  if (!spdlog::should_log(level)) return;
  if (!logs_to_journal()) return spdlog::log(level, "{}", line);
  std::vector<std::string> entries = {"MESSAGE=" + line,
                                      "PRIORITY=" + std::to_string(syslog_priority(level)),
                                      "SYSLOG_IDENTIFIER=" + spdlog::default_logger()->name()};
  for (const LogField& field : fields)
    entries.push_back(std::string(field.name) + "=" + field.value);
  std::vector<iovec> parts;
  for (std::string& entry : entries) parts.push_back({entry.data(), entry.size()});
  if (sd_journal_sendv(parts.data(), static_cast<int>(parts.size())) < 0) {
    spdlog::log(level, "{}", line);
  }
}

}  // namespace infuse::daemon
