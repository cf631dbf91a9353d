#pragma once

#include <string>

#include "daemon/setup/drive_setup.hpp"

namespace infuse::daemon {

/// Index of the lidar of that name, or of the only one if the name is empty.
Result<size_t> find_lidar(const SensorSetup& setup, const std::string& name);

}  // namespace infuse::daemon
