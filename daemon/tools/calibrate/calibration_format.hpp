#pragma once

#include <string>

#include "daemon/protocol/json.hpp"
#include "daemon/tools/calibrate/calibration_run.hpp"

namespace infuse::daemon {

/// Formats the result as JSON: `T_camera_lidar`, `covariance`, `usable`, `reason` and the evidence
/// for them.
Json to_json(const CalibrationRun& run, const ScenePairs& pairs);

/// Formats the result as several lines of text.
std::string to_text(const CalibrationRun& run, const ScenePairs& pairs);

}  // namespace infuse::daemon
