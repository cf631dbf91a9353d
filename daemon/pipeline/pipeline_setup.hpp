#pragma once

#include <optional>
#include <vector>

#include "daemon/pipeline/delivery.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/sensor_index.hpp"
#include "daemon/pipeline/vehicle_setup.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// Sensors of the pipeline, live or in a replay.
struct PipelineSetup {
  Delivery delivery = Delivery::kWait;
  std::vector<LidarSetup> lidars;             ///< in the order of the rig
  std::vector<camera::ImageOptions> cameras;  ///< decoding options: cameras of the rig, then those
                                              ///< without a mount
  VehicleSetup vehicle;
  /// Lidar whose position packets carry the NMEA sentences of the GNSS receiver, if it has no
  /// stream of its own. `vehicle.has_gnss` is true then.
  std::optional<LidarIndex> gnss_lidar;
  Rig rig;  ///< mounts of the sensors
  /// Lidars, cameras, buses, speed sensor, inertial unit, GNSS receiver.
  std::vector<Device> devices;

  /// Number of devices that are not lidars.
  size_t stream_count() const { return devices.size() - lidars.size(); }
};

}  // namespace infuse::daemon
