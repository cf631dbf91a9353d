#pragma once

#include <string>

#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// Returns a report or reply as one line of JSON, without its line feed. Defined for every message
/// of `descriptions.hpp`.
template <class Report>
std::string message(const Report& report);

}  // namespace infuse::daemon
