#pragma once

#include <spdlog/common.h>

#include <span>
#include <string>

namespace infuse::daemon {

/// Sends the log of the program `name` to the journal, with levels, if standard error is the
/// journal's; otherwise to standard error.
void set_up_logging(const std::string& name);

/// A field of a line in the journal, as systemd.journal-fields(7) has them.
struct LogField {
  const char* name;  ///< "INFUSE_DEVICE"
  std::string value;
};

/// Logs a line. In the journal it has these fields too; elsewhere they are left out.
void log_line(spdlog::level::level_enum level, const std::string& line,
              std::span<const LogField> fields);

}  // namespace infuse::daemon
