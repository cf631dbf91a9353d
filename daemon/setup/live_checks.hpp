#pragma once

#include <vector>

#include "daemon/config/config.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

// What a configuration asks for and a host cannot give, beyond what each table says by itself:
// checked by --check-config and at the start, so that the one passes what the other does. Errors
// name file and line.

/// Ports that are used twice, files that cannot be read, folders that are missing.
Result<void> check_services(const Config& config);

/// Two sensors on one device, `use_lidar` without a lidar.
Result<void> check_sensors(const Config& config);

/// Valid settings that are probably mistakes.
std::vector<Error> find_doubts(const Config& config, const Rig& rig);

}  // namespace infuse::daemon
