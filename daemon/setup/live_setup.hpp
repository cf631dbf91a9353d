#pragma once

#include "daemon/config/config.hpp"
#include "daemon/setup/sensor_setup.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Sets up the sensors of this host as configured. Lidars that are not in the rig are mounted at
/// the vehicle's origin; cameras that are not in the rig are only counted. Errors: a lidar without
/// a model, a rig or DBC file that cannot be read, an image size that differs from the rig's.
Result<SensorSetup> set_up_live(const Config& config);

}  // namespace infuse::daemon
