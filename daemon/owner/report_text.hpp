#pragma once

#include <string>
#include <vector>

#include "daemon/health/level.hpp"
#include "daemon/protocol/json.hpp"

namespace infuse::daemon {

/// Returns the text of a key; empty if the key is absent.
std::string text_of(const Json& object, const char* key);

/// Formats a message of the daemon as text: one line, or for HEALTH one line per sensor and
/// finding. Unknown classes are printed as JSON.
std::string report_text(const Json& message);

/// Formats the progress of a RECORD message.
std::string record_text(const Json& record);

/// Formats the sensors of a HEALTH message.
std::string health_text(const Json& health);

/// Formats the stamp (ns) under a key: "2026-11-21T03:12:55Z".
std::string utc_text(const Json& object, const char* key);

/// Returns the level under a key; kOk if it is absent or unknown.
Level level_of(const Json& object, const char* key);

/// A finding of a HEALTH message.
struct NamedFinding {
  std::string device;  ///< the sensor or stage; "infused" for what concerns all of them
  Json finding;
  bool of_calibration = false;  ///< of the calibration of the camera `device`
};

/// Lists the findings of a HEALTH message.
std::vector<NamedFinding> findings_of(const Json& health);

/// State of a daemon.
struct DaemonStatus {
  Level level = Level::kOk;  ///< that of HEALTH; kOk without a HEALTH report
  std::string text;          ///< the recording and HEALTH
};

/// Returns the state of a daemon by its last report of every class and device.
DaemonStatus daemon_status(const std::vector<Json>& reports);

}  // namespace infuse::daemon
