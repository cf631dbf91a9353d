#pragma once

#include <optional>
#include <vector>

#include "daemon/pipeline/delivery.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/vehicle_setup.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// What the pipeline is told of the sensors, wherever their data come from.
struct PipelineSetup {
  Delivery delivery = Delivery::kWait;
  std::vector<LidarSetup> lidars;             ///< as in the rig
  std::vector<camera::ImageOptions> cameras;  ///< how each one's picture files are read; those
                                              ///< of the rig, then cameras without a place in it
  VehicleSetup vehicle;
  /// Lidar whose position packets carry the NMEA sentences of the GNSS receiver, if it has no
  /// stream of its own. `vehicle.has_gnss` is true then.
  std::optional<size_t> gnss_lidar;
  Rig rig;                      ///< where the sensors are
  std::vector<Device> devices;  ///< lidars, cameras, then buses, inertial unit and receiver

  /// Devices that are no lidars.
  size_t stream_count() const { return devices.size() - lidars.size(); }
};

}  // namespace infuse::daemon
