#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/velodyne/model.hpp"

namespace infuse::daemon {

/// A drive or a bare capture, ready to be read.
struct DriveSetup {
  std::filesystem::path path;
  recording::DriveSource source;
  std::vector<LidarSetup> lidars;  ///< by index in the source's events
  std::vector<Device> devices;     ///< the same, for people
  uint64_t capture_bytes = 0;      ///< of all captures; 0 where there is none
};

/// Opens a drive folder or a bare pcap. Of a drive, drive.toml says which lidars there are; of a
/// bare capture, `lidars` of the configuration, or where it names none, every stream of lidar
/// packets at the beginning of the capture. The model is `model` where given, else the one that is
/// configured, else the one that the packets show.
Result<DriveSetup> open_drive(const std::filesystem::path& path,
                              const std::vector<LidarOptions>& lidars,
                              std::optional<velodyne::Model> model);

}  // namespace infuse::daemon
