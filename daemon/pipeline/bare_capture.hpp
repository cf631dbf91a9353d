#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/survey/capture_survey.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/velodyne/calibration.hpp"

namespace infuse::daemon {

/// Surveys the beginning of a capture (a path as of `find_capture_parts`), enough to identify its
/// sensors.
Result<CaptureSurvey> survey_beginning(const std::filesystem::path& path);

/// Describes a bare capture as a drive: one lidar for each of `lidars`, or if that is empty, one
/// for each stream of data packets in the survey. Errors: no lidar.
Result<recording::Drive> describe_capture(const std::filesystem::path& capture,
                                          const CaptureSurvey& survey,
                                          const std::vector<LidarOptions>& lidars);

/// Data packets of a lidar at the beginning of its capture; null if there are none.
const Stream* find_data_stream(const CaptureSurvey& survey, const recording::LidarFiles& files);

/// Reads the calibration that an HDL-64E sends in its packets; nothing if the beginning of the
/// capture does not hold all of it.
std::optional<velodyne::Calibration> find_streamed_calibration(const std::filesystem::path& path,
                                                               const recording::LidarFiles& files,
                                                               velodyne::Model model);

}  // namespace infuse::daemon
