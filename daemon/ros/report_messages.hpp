#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ros/message_sink.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Writes reports, lines of JSON, as messages: poses on /odometry/odom and /odometry/map
/// (nav_msgs/Odometry), and on /tf as odom→base_link and, where both are known at a time, map→odom
/// (REP 105: a frame has one parent); alerts and, of HEALTH, what is known of each device on
/// /diagnostics (DiagnosticArray). Poses that are not usable and other reports are left out.
class ReportMessages {
 public:
  /// `sink` outlives this.
  explicit ReportMessages(MessageSink& sink) : sink_(sink) {}

  /// False if the line is not a report.
  bool write(const std::string& line);

 private:
  /// The last pose in the odometry frame.
  struct OdometryPose {
    Stamp stamp;
    Eigen::Isometry3d T_odom_vehicle;
  };

  bool write_pose(const nlohmann::json& report, Stamp stamp);

  MessageSink& sink_;
  std::optional<OdometryPose> odometry_;
};

/// Writes the reports of a replay, a file of such lines (`infused --replay --reports`). Lines that
/// are not reports are counted in a note.
Result<void> write_report_messages(const std::filesystem::path& reports, MessageSink& sink,
                                   std::vector<Error>& notes);

/// Converts a covariance of infuse, of a left perturbation (rx ry rz tx ty tz) of T_frame_vehicle,
/// to one of ROS: (x y z, rotation about the fixed axes x y z) of the vehicle at `position`.
std::array<double, 36> to_ros_covariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                         const Eigen::Vector3d& position);

}  // namespace infuse::daemon
