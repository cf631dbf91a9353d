#include "daemon/ros/message_setup.hpp"

namespace infuse::daemon {
namespace {

/// The model's maker, if there is a message for its packets; else null.
const lidar::LidarMaker* packet_maker(const lidar::LidarModel& model) {
  return model.maker->ros_packets() != lidar::RosPackets::kNone ? model.maker : nullptr;
}

}  // namespace

MessageSetup message_setup(const PipelineSetup& setup) {
  MessageSetup messages{.rig = setup.rig};
  for (const LidarSetup& lidar : setup.lidars) {
    messages.packet_makers.push_back(lidar.has_packets ? packet_maker(*lidar.decoder.model)
                                                       : nullptr);
  }
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
