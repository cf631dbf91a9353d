#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/setup/sensor_setup.hpp"
#include "drivers/lidar/lidar_maker.hpp"

namespace infuse::daemon {

/// What the messages need to know of the sensors.
struct MessageSetup {
  Rig rig;
  /// By lidar: the maker of its packets, if there is a message for them; null: sweeps are written.
  std::vector<const lidar::LidarMaker*> packet_makers;
  std::vector<std::optional<PixelFormat>> mosaics;  ///< by camera: of its image files
  std::optional<size_t> gnss_lidar;                 ///< whose information packets carry the fixes
  bool has_bus = false, has_motion = false;         ///< a bus; a speed or inertial unit of its own
  bool has_gnss = false;
  bool live = false;
};

MessageSetup message_setup(const SensorSetup& setup);

}  // namespace infuse::daemon
