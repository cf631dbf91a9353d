#include "daemon/ros/message_setup.hpp"

namespace infuse::daemon {

MessageSetup message_setup(const PipelineSetup& setup) {
  MessageSetup messages{.rig = setup.rig};
  for (const LidarSetup& lidar : setup.lidars) messages.has_packets.push_back(lidar.has_packets);
  for (const camera::ImageOptions& camera : setup.cameras) messages.mosaics.push_back(camera.bayer);
  if (setup.gnss_lidar) messages.gnss_lidar = *setup.gnss_lidar;
  for (const Device& device : setup.devices) {
    messages.has_bus |= device.kind == "can";
    messages.has_motion |= device.kind == "speed" || device.kind == "imu";
  }
  messages.has_gnss = setup.vehicle.has_gnss;
  messages.live = setup.delivery == Delivery::kOverwrite;
  return messages;
}

}  // namespace infuse::daemon
