#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/pipeline/pipeline_setup.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/velodyne/model.hpp"

namespace infuse::daemon {

/// A drive or a bare capture, ready to be read. Sensors have the indices of the source's events.
struct DriveSetup : PipelineSetup {
  std::filesystem::path path;
  recording::DriveSource source;
  uint64_t capture_bytes = 0;  ///< of all captures; 0 if there are none
};

/// What the command line says about the lidars of a drive; it precedes drive.toml.
struct LidarOverrides {
  std::optional<velodyne::Model> model{};
  std::filesystem::path calibration{};  ///< db.xml of the unit; empty: none
};

/// Opens a drive folder or a bare capture (`find_capture_parts`). In a drive, drive.toml names the
/// lidars; in a bare capture, `lidars` of the configuration does, or if it is empty, every stream
/// of data packets at the beginning of the capture is a lidar. The model is that of `overrides` if
/// given, else the configured one, else the one inferred from the packets. The calibration of an
/// HDL-64E is that of `overrides` if given, else the configured one, else the one in its packets.
Result<DriveSetup> open_drive(const std::filesystem::path& path,
                              const std::vector<LidarOptions>& lidars,
                              const LidarOverrides& overrides);

}  // namespace infuse::daemon
