#pragma once

#include <map>
#include <optional>
#include <string>

#include "daemon/protocol/reports.hpp"
#include "daemon/protocol/request.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Returns why there is nothing to apply or to roll back, given the last report of each camera;
/// nothing if there is, and for other requests.
std::optional<Error> check_request(const Request& request,
                                   const std::map<std::string, CalibrationReport>& calibrations);

}  // namespace infuse::daemon
