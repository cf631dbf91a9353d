#pragma once

#include <string>

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

}  // namespace infuse::daemon
