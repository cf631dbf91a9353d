#pragma once

#include <cstdint>

#include "daemon/pipeline/sensor_index.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// Returns the SWEEP report of a sweep, without the figures of deskewing.
SweepReport summarise(const Sweep& sweep, LidarIndex lidar);

}  // namespace infuse::daemon
