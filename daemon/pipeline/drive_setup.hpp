#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/vehicle_setup.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/camera/picture.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/velodyne/model.hpp"

namespace infuse::daemon {

/// A drive or a bare capture, ready to be read.
struct DriveSetup {
  std::filesystem::path path;
  recording::DriveSource source;
  std::vector<LidarSetup> lidars;               ///< by index in the source's events
  std::vector<camera::PictureOptions> cameras;  ///< how each one's pictures are read
  VehicleSetup vehicle;
  bool has_can = false;         ///< there is a bus, of use or not
  Rig rig;                      ///< where all of them are
  std::vector<Device> devices;  ///< lidars, cameras, then the bus, inertial unit and receiver
  uint64_t capture_bytes = 0;   ///< of all captures; 0 where there is none

  /// Devices that are no lidars.
  size_t streams() const { return devices.size() - lidars.size(); }
};

/// Opens a drive folder or a bare pcap. Of a drive, drive.toml says which lidars there are; of a
/// bare capture, `lidars` of the configuration, or where it names none, every stream of lidar
/// packets at the beginning of the capture. The model is `model` where given, else the one that is
/// configured, else the one that the packets show.
Result<DriveSetup> open_drive(const std::filesystem::path& path,
                              const std::vector<LidarOptions>& lidars,
                              std::optional<velodyne::Model> model);

}  // namespace infuse::daemon
