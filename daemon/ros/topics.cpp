#include "daemon/ros/topics.hpp"

#include "drivers/ros/messages.hpp"

namespace infuse::daemon {

std::string lidar_frame(const Rig& rig, size_t lidar) { return "lidar_" + rig.lidars[lidar].name; }
std::string camera_frame(const Rig& rig, size_t camera) {
  return "camera_" + rig.cameras[camera].name;
}

LidarTopics::LidarTopics(const std::string& name)
    : packets("/lidar/" + name + "/packets"),
      position_packets("/lidar/" + name + "/position_packets"),
      metadata("/lidar/" + name + "/metadata"),
      points_raw("/lidar/" + name + "/points_raw"),
      points("/lidar/" + name + "/points") {}

CameraTopics::CameraTopics(const std::string& name)
    : image("/camera/" + name + "/image_raw/compressed"),
      info("/camera/" + name + "/camera_info") {}

std::string vehicle_topic(bool from_bus) { return from_bus ? "/vehicle/bus" : "/vehicle"; }

std::vector<TopicInfo> list_topics(const MessageSetup& setup) {
  std::vector<TopicInfo> topics{{kTransformsTopic, ros::TfMessage::kName, true}};
  const auto add = [&](const std::string& topic, const char* type) {
    for (const TopicInfo& each : topics) {
      if (each.topic == topic) return;
    }
    topics.push_back({topic, type, false});
  };
  for (size_t k = 0; k < setup.rig.lidars.size(); ++k) {
    const LidarTopics lidar(setup.rig.lidars[k].name);
    if (const lidar::LidarMaker* maker = setup.packet_makers[k]) {
      const PacketTypes types = packet_types(*maker);
      add(lidar.packets, types.data);
      if (types.others != nullptr) add(lidar.position_packets, types.others);
      if (!setup.packet_metadata[k].empty())
        topics.push_back({lidar.metadata, ros::String::kName, true});
    }
    add(lidar.points_raw, ros::PointCloud2::kName);
    add(lidar.points, ros::PointCloud2::kName);
  }
  for (const CameraMount& mount : setup.rig.cameras) {
    const CameraTopics camera(mount.name);
    add(camera.image, ros::CompressedImage::kName);
    add(camera.info, ros::CameraInfo::kName);
  }
  const auto add_motion = [&](bool from_bus) {
    add(vehicle_topic(from_bus) + "/twist", ros::TwistWithCovarianceStamped::kName);
    add(vehicle_topic(from_bus) + "/imu", ros::Imu::kName);
  };
  if (setup.has_bus) add_motion(true);
  if (setup.has_motion) add_motion(false);
  if (setup.has_gnss) {
    add("/gnss/fix", ros::NavSatFix::kName);
    add("/gnss/vel", ros::TwistStamped::kName);
  }
  for (const char* topic : kEstimateTopics) add(topic, ros::Odometry::kName);
  add("/tf", ros::TfMessage::kName);
  add(kDiagnosticsTopic, ros::DiagnosticArray::kName);
  return topics;
}

}  // namespace infuse::daemon
