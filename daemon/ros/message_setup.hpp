#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/pipeline_setup.hpp"

namespace infuse::daemon {

/// What the messages need to know of the sensors.
struct MessageSetup {
  Rig rig;
  std::vector<bool> has_packets;                    ///< by lidar; false: decoded sweeps
  std::vector<std::optional<PixelFormat>> mosaics;  ///< by camera: of its image files
  std::optional<size_t> gnss_lidar;                 ///< whose position packets carry the fixes
  bool has_bus = false, has_motion = false;         ///< a bus; a speed or inertial unit of its own
  bool has_gnss = false;
  bool live = false;
};

MessageSetup message_setup(const PipelineSetup& setup);

}  // namespace infuse::daemon
