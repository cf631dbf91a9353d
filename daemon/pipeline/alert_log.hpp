#pragma once

#include <spdlog/common.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/process/logging.hpp"
#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// A line of the log about an alert.
struct AlertLine {
  spdlog::level::level_enum level;
  std::string text;
  std::vector<LogField> fields;
};

/// The story of a drive in the log: a line when an alert is raised, and one when it is cleared. An
/// alert that comes and goes is left out for a while, and its next line says how often.
class AlertLog {
 public:
  static constexpr int kMaxRaised = 3;                   ///< lines of one alert raised within
  static constexpr Duration kInterval{600'000'000'000};  ///< this time

  /// Logs the line of a report, if it has one, at its level or at `max_level` if that is lower.
  void add(const AlertReport& alert, spdlog::level::level_enum max_level = spdlog::level::err);

  /// Returns the line of a report; nothing if it is left out. What is raised in a line is cleared
  /// in one. The level is that of the alert; warn for one that is cleared, so that both are in
  /// `journalctl -p warning`.
  std::optional<AlertLine> line(const AlertReport& alert);

 private:
  /// What was written about one alert.
  struct Written {
    Stamp since;            // start of the interval
    int raised = 0;         // lines within it
    uint64_t left_out = 0;  // since the last line
    bool open = false;      // the last line raised it
  };

  std::map<std::string, Written> written_;  // by id
};

}  // namespace infuse::daemon
