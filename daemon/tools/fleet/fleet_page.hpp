#pragma once

#include <string>

#include "daemon/tools/fleet/fleet_summary.hpp"

namespace infuse::daemon {

/// Makes the page of a fleet: vehicles with their verdicts, each camera's pose over time with bands
/// of 95 %, and what failed, with its reason. One HTML text without script; a
/// Content-Security-Policy forbids loading anything. Bytes depend on the summary alone.
std::string make_fleet_page(const FleetSummary& fleet);

}  // namespace infuse::daemon
