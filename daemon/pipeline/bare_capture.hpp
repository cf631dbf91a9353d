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

/// The beginning of a capture: enough to tell which sensors are in it.
Result<CaptureSurvey> survey_beginning(const std::filesystem::path& path);

/// The drive that a bare capture would be: a lidar for each of `lidars`, or where there is none,
/// for each stream of lidar packets in the survey. An error where that gives no lidar.
Result<recording::Drive> describe_capture(const std::filesystem::path& path,
                                          const CaptureSurvey& survey,
                                          const std::vector<LidarOptions>& lidars);

/// The model of the stream that a lidar's files name, as its packets show it; nothing where they
/// show none.
std::optional<velodyne::InferredModel> infer_model(const CaptureSurvey& survey,
                                                   const recording::LidarFiles& files);

}  // namespace infuse::daemon
