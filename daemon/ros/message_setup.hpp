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
  /// By lidar: the maker of its packets, if there is a message for them; else null.
  std::vector<const lidar::LidarMaker*> packet_makers;
  /// By lidar: what its packets cannot be read without (an Ouster's metadata); empty: nothing.
  std::vector<std::string> packet_metadata;
  std::vector<std::optional<PixelFormat>> mosaics;  ///< by camera: of its image files
  std::optional<size_t> gnss_lidar;                 ///< whose information packets carry the fixes
  bool has_bus = false, has_motion = false;         ///< a bus; a speed or inertial unit of its own
  bool has_gnss = false;
  bool live = false;
};

/// True if a maker's packets are written instead of clouds as measured: other programs than the
/// maker's own driver read them. `maker` may be null.
bool replaces_clouds(const lidar::LidarMaker* maker);

/// Message types of a maker's data packets, and of its other packets; null: they have no topic of
/// their own.
struct PacketTypes {
  const char* data = nullptr;
  const char* others = nullptr;
};
PacketTypes packet_types(const lidar::LidarMaker& maker);

MessageSetup message_setup(const SensorSetup& setup);

}  // namespace infuse::daemon
