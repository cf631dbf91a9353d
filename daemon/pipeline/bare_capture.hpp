#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/survey/capture_survey.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"

namespace infuse::daemon {

/// Surveys the beginning of a capture, enough to identify its sensors.
Result<CaptureSurvey> survey_beginning(const std::filesystem::path& path);

/// Describes a bare capture as a drive: one lidar for each of `lidars`, or if that is empty, one
/// for each stream of data packets in the survey. Errors: no lidar.
Result<recording::Drive> describe_capture(const std::filesystem::path& path,
                                          const CaptureSurvey& survey,
                                          const std::vector<LidarOptions>& lidars);

/// Infers the model of a lidar from its data packets; nothing if they do not show it.
std::optional<velodyne::InferredModel> infer_model(const CaptureSurvey& survey,
                                                   const recording::LidarFiles& files);

}  // namespace infuse::daemon
