#include "daemon/process/logging.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/systemd_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

namespace infuse::daemon {
namespace {

/// True if standard error is the journal: systemd puts its device and inode into $JOURNAL_STREAM.
bool logs_to_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat about {};
  if (stream == nullptr || fstat(STDERR_FILENO, &about) != 0) return false;
  return std::to_string(about.st_dev) + ":" + std::to_string(about.st_ino) == stream;
}

}  // namespace

void set_up_logging(const std::string& name) {
  spdlog::set_default_logger(logs_to_journal() ? spdlog::systemd_logger_mt(name, name)
                                               : spdlog::stderr_color_mt(name));
}

}  // namespace infuse::daemon
