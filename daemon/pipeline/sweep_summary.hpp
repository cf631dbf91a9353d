#pragma once

#include <string_view>

#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// Returns the SWEEP report of a sweep, without the figures of deskewing. `device`: name of the
/// lidar, which outlives the report.
SweepReport summarise(const Sweep& sweep, std::string_view device);

}  // namespace infuse::daemon
