#pragma once

#include <string>
#include <vector>

#include "daemon/protocol/json.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Asks the running daemon for the CALIBRATION reports of all cameras, or of one. Error: there is
/// none.
Result<std::vector<Json>> poll_calibrations(const std::string& socket, const std::string& camera);

}  // namespace infuse::daemon
