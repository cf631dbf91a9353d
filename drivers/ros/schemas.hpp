#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace infuse::ros {

/// Returns the definition of a message type in ROS 2's interface language ("ros2msg"), followed by
/// those of the types that it contains, as rosbag2 stores it. `name` is that of a message of
/// messages.hpp, "sensor_msgs/msg/Imu". Nothing for other types.
std::optional<std::string> schema_of(std::string_view name);

/// Returns a type's name in ROS 2's form: "sensor_msgs/Imu" of ROS 1 and
/// "sensor_msgs::msg::dds_::Imu_" of DDS become "sensor_msgs/msg/Imu".
/// Empty if the name is not of a package and a type.
std::string normalise_type(std::string_view name);

}  // namespace infuse::ros
