#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "drivers/import/bag_frames.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/ros/messages.hpp"

namespace infuse::importers {

/// Header stamps of a topic against the times at which its messages were recorded, s.
struct StampLag {
  size_t messages = 0;  ///< with a header stamp
  double median = 0;    ///< log time minus header stamp
  double smallest = 0, largest = 0;
};

/// What a recording contains on a topic.
struct BagTopic {
  std::string name;
  std::string type;  ///< "sensor_msgs/msg/Imu"
  size_t messages = 0;
  size_t unreadable = 0;  ///< that are not messages of the type
  size_t stampless = 0;   ///< whose header has no stamp
  std::string frame;      ///< of the first header
  StampLag lag;
  bool is_measured = false;       ///< a twist is not zero, an inertial sample is finite
  bool has_data_packets = false;  ///< its packets are, among others, data packets of a lidar
  bool has_x = false, has_y = false, has_turns = false;  ///< components of twists that are not zero
};

/// What recordings contain.
struct BagSurvey {
  std::vector<BagTopic> topics;  ///< by name
  FrameTree frames;
  std::map<std::string, ros::CameraInfo> camera_infos;  ///< the first of each topic
  std::map<std::string, std::map<std::string, std::string>> metadata;
  std::vector<Error> notes;  ///< about the files
  const BagTopic* find(const std::string& name) const;
};

/// Reads recordings once, for their topics, frames and cameras.
Result<BagSurvey> survey_bags(const std::vector<std::filesystem::path>& files);

/// A lidar of a recording.
struct BagLidar {
  std::string name;       ///< from the topic
  std::string topic;      ///< of its scans or clouds
  std::string positions;  ///< topic of its packets of other kinds; empty: none
  std::string metadata;   ///< topic of its unit's metadata as text; empty: none
  std::string frame;
  bool has_packets = false;
};

/// A camera of a recording.
struct BagCamera {
  std::string name;
  std::string topic;
  std::string frame;
  bool compressed = false;
  bool rectified = false;
  ros::CameraInfo info;
};

/// The topics that become a drive.
struct BagSelection {
  std::vector<BagLidar> lidars;
  std::vector<BagCamera> cameras;
  std::string speed;  ///< topic of twists or odometry; empty: none
  std::string imu;
  std::string gnss;
  std::string velocity;  ///< topic of the velocities beside the fixes, as `velocity_beside`
  std::map<std::string, std::string> reasons;  ///< why a topic is not taken, by topic
};

/// Returns the topic of velocities over ground beside a topic of fixes, as ROS drivers of GNSS
/// receivers publish them; empty if there is none. It is in the same namespace, "vel" is in its
/// name, and its twists are in the fix's frame of east and north: they do not turn and are not all
/// along x, as those of a vehicle are.
std::string velocity_beside(const BagSurvey& survey, const std::string& fixes);

/// Selects topics by their types. If `wanted` names topics of a kind (lidars, cameras, speed,
/// inertial, GNSS), no others of that kind are taken. Fails where it is ambiguous, and names the
/// topics to choose from; and where a wanted topic does not exist.
Result<BagSelection> select_topics(const BagSurvey& survey, const std::set<std::string>& wanted);

}  // namespace infuse::importers
