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

/// A drive or a bare capture, ready to be read. Sensors have the index that they have in the
/// source's events.
struct DriveSetup : PipelineSetup {
  std::filesystem::path path;
  recording::DriveSource source;
  uint64_t capture_bytes = 0;  ///< of all captures; 0 where there is none
};

/// Opens a drive folder or a bare pcap. Of a drive, drive.toml says which lidars there are; of a
/// bare capture, `lidars` of the configuration, or where it names none, every stream of lidar
/// packets at the beginning of the capture. The model is `model` where given, else the one that is
/// configured, else the one that the packets show.
Result<DriveSetup> open_drive(const std::filesystem::path& path,
                              const std::vector<LidarOptions>& lidars,
                              std::optional<velodyne::Model> model);

}  // namespace infuse::daemon
