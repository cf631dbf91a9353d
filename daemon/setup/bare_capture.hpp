#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "drivers/makers/capture_survey.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"

namespace infuse::daemon {

/// Surveys the beginning of a capture (a path as of `find_capture_parts`), enough to identify its
/// sensors.
Result<makers::CaptureSurvey> survey_beginning(const std::filesystem::path& path);

/// Describes a bare capture as a drive: one lidar for each of `lidars`, or if that is empty, one
/// for each stream of data packets in the survey. Errors: no lidar.
Result<recording::Drive> describe_capture(const std::filesystem::path& capture,
                                          const makers::CaptureSurvey& survey,
                                          const std::vector<LidarOptions>& lidars);

/// Data packets of a lidar at the beginning of its capture; null if there are none.
const makers::Stream* find_data_stream(const makers::CaptureSurvey& survey,
                                       const recording::LidarFiles& files);

/// Reads the calibration that a lidar sends itself; null if the beginning of the capture does not
/// hold all of it. The options must be valid.
std::shared_ptr<const lidar::UnitCalibration> find_streamed_calibration(
    const std::filesystem::path& path, const recording::LidarFiles& files,
    const lidar::DecoderOptions& options);

}  // namespace infuse::daemon
