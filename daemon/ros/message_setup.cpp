#include "daemon/ros/message_setup.hpp"

#include "drivers/ros/messages.hpp"

namespace infuse::daemon {
namespace {

/// The model's maker, if there is a message for its packets; else null.
const lidar::LidarMaker* packet_maker(const lidar::LidarModel& model) {
  return model.maker->ros_packets() != lidar::RosPackets::kNone ? model.maker : nullptr;
}

}  // namespace

bool replaces_clouds(const lidar::LidarMaker* maker) {
  return maker != nullptr && maker->ros_packets() == lidar::RosPackets::kVelodyneScan;
}

PacketTypes packet_types(const lidar::LidarMaker& maker) {
  switch (maker.ros_packets()) {
    case lidar::RosPackets::kVelodyneScan:
      return {ros::VelodyneScan::kName, ros::UInt8MultiArray::kName};
    case lidar::RosPackets::kPandarScan:
      return {ros::PandarScan::kName, ros::UInt8MultiArray::kName};
    case lidar::RosPackets::kRslidarPacket:
      return {ros::RslidarPacket::kName, nullptr};
    case lidar::RosPackets::kOusterPacket:
      return {ros::OusterPacket::kName, ros::OusterPacket::kName};
    case lidar::RosPackets::kNone:
      break;
  }
  return {};
}

MessageSetup message_setup(const SensorSetup& setup) {
  MessageSetup messages{.rig = setup.rig};
  for (const LidarSetup& lidar : setup.lidars) {
    messages.packet_makers.push_back(lidar.has_packets ? packet_maker(*lidar.decoder.model)
                                                       : nullptr);
    const auto& unit = lidar.decoder.calibration;
    const bool has_text = messages.packet_makers.back() != nullptr && unit != nullptr;
    messages.packet_metadata.emplace_back(has_text ? unit->text() : std::string_view());
  }
  for (const CameraSetup& camera : setup.cameras) messages.mosaics.push_back(camera.image.bayer);
  if (setup.gnss_lidar) messages.gnss_lidar = *setup.gnss_lidar;
  messages.has_bus = !setup.vehicle.buses.empty();
  messages.has_motion = setup.vehicle.speed || setup.vehicle.imu;
  messages.has_gnss = setup.vehicle.gnss.has_value();
  messages.live = setup.live;
  return messages;
}

}  // namespace infuse::daemon
