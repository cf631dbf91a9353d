#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/ros/message_sink.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Writes a report, a line of JSON, as messages: poses on /odometry/odom and /odometry/map
/// (nav_msgs/Odometry), the first also on /tf as odom→base_link; alerts and, of HEALTH, what is
/// known of each device on /diagnostics (DiagnosticArray). Poses that are not usable and other
/// reports are left out. False if the line is not a report.
bool write_report_message(const std::string& line, MessageSink& sink);

/// Writes the reports of a replay, a file of such lines (`infused --replay --reports`). Lines that
/// are not reports are counted in a note.
Result<void> write_report_messages(const std::filesystem::path& reports, MessageSink& sink,
                                   std::vector<Error>& notes);

/// Converts a covariance of infuse, of a left perturbation (rx ry rz tx ty tz) of T_frame_vehicle,
/// to one of ROS: (x y z, rotation about the fixed axes x y z) of the vehicle at `position`.
std::array<double, 36> to_ros_covariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                         const Eigen::Vector3d& position);

}  // namespace infuse::daemon
