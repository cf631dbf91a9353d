#pragma once

#include <string>

#include "daemon/protocol/counters_json.hpp"

namespace infuse::daemon {

/// A message of the daemon, for people: one line, or of HEALTH a line a sensor and a finding. What
/// it does not know it gives as JSON.
std::string report_text(const Json& message);

/// Of a RECORD message, what the recording has come to.
std::string record_text(const Json& record);

/// Of a HEALTH message, how every sensor is.
std::string health_text(const Json& health);

}  // namespace infuse::daemon
