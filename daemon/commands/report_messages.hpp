#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <vector>

#include "daemon/commands/ros_file.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Writes the reports of a replay (a file of JSON lines, `infused --replay --reports`) as messages:
/// poses on /odometry/odom and /odometry/map (nav_msgs/Odometry), the first also on /tf as
/// odom→base_link, alerts on /diagnostics (DiagnosticArray). Poses that are not usable are left
/// out. Lines that are not reports are counted in a note.
Result<void> write_report_messages(const std::filesystem::path& reports, RosFile& file,
                                   std::vector<Error>& notes);

/// Converts a covariance of infuse, of a left perturbation (rx ry rz tx ty tz) of T_frame_vehicle,
/// to one of ROS: (x y z, rotation about the fixed axes x y z) of the vehicle at `position`.
std::array<double, 36> to_ros_covariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                         const Eigen::Vector3d& position);

}  // namespace infuse::daemon
