#pragma once

#include <string>
#include <vector>

#include "daemon/ros/message_setup.hpp"

namespace infuse::daemon {

/// Frames of the messages.
inline constexpr const char* kVehicleFrame = "base_link";
inline constexpr const char* kGnssFrame = "gnss";
std::string lidar_frame(const Rig& rig, size_t lidar);
std::string camera_frame(const Rig& rig, size_t camera);

/// Topics of a lidar.
struct LidarTopics {
  explicit LidarTopics(const std::string& name);
  std::string packets, position_packets, metadata, points_raw, points;
};

/// Topics of a camera.
struct CameraTopics {
  explicit CameraTopics(const std::string& name);
  std::string image, info;
};

/// Beginning of the topics of vehicle samples: of the bus, or of sensors of their own.
std::string vehicle_topic(bool from_bus);

inline constexpr const char* kTransformsTopic = "/tf_static";
/// Topics of what infuse estimates: an import takes them for no sensor's.
inline constexpr const char* kEstimateTopics[] = {"/odometry/odom", "/odometry/map"};
inline constexpr const char* kDiagnosticsTopic = "/diagnostics";

/// A topic that a run may have.
struct TopicInfo {
  std::string topic;
  const char* type = "";  ///< of its messages: "sensor_msgs/msg/Imu"
  bool latched = false;
};

/// Topics that a run with these sensors may have.
std::vector<TopicInfo> list_topics(const MessageSetup& setup);

}  // namespace infuse::daemon
