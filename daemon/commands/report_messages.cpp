#include "daemon/commands/report_messages.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "drivers/ros/messages.hpp"

namespace infuse::daemon {
namespace {

using ReportJson = nlohmann::json;

/// The numbers of an array of that length; nothing otherwise.
template <size_t N>
std::optional<std::array<double, N>> numbers(const ReportJson& report, const char* key) {
  const auto found = report.find(key);
  if (found == report.end() || !found->is_array() || found->size() != N) return std::nullopt;
  std::array<double, N> values{};
  for (size_t k = 0; k < N; ++k) {
    if (!(*found)[k].is_number()) return std::nullopt;
    values[k] = (*found)[k].get<double>();
  }
  return values;
}

std::string text_of(const ReportJson& report, const char* key) {
  const auto found = report.find(key);
  return found != report.end() && found->is_string() ? found->get<std::string>() : "";
}

double number_of(const ReportJson& report, const char* key) {
  const auto found = report.find(key);
  return found != report.end() && found->is_number() ? found->get<double>() : 0;
}

bool write_pose(const ReportJson& report, Stamp stamp, RosFile& file) {
  const auto usable = report.find("usable");
  if (usable == report.end() || !usable->is_boolean() || !usable->get<bool>()) return true;
  const std::string frame = text_of(report, "frame");
  const auto matrix = numbers<16>(report, "T_frame_vehicle");
  const auto covariance = numbers<36>(report, "covariance");
  if ((frame != "odom" && frame != "map") || !matrix || !covariance) return false;
  Eigen::Isometry3d T_frame_vehicle;
  T_frame_vehicle.matrix() =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix->data());
  const Eigen::Matrix<double, 6, 6> by_row =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(covariance->data());
  ros::Odometry message;
  message.header = {0, ros::Time::from(stamp), frame};
  message.child_frame_id = "base_link";
  message.pose = ros::to_transform(T_frame_vehicle);
  message.pose_covariance = to_ros_covariance(by_row, T_frame_vehicle.translation());
  message.twist.linear.x = number_of(report, "speed");
  message.twist.angular.z = number_of(report, "yaw_rate");
  file.write("/odometry/" + frame, stamp, message);
  if (frame == "odom")
    file.write("/tf", stamp, ros::TfMessage{{{message.header, "base_link", message.pose}}});
  return true;
}

bool write_alert(const ReportJson& report, Stamp stamp, RosFile& file) {
  const std::string severity = text_of(report, "severity");
  const std::string state = text_of(report, "state");
  if (state != "raised" && state != "cleared") return false;
  ros::DiagnosticStatus status;
  status.level = state == "cleared" || severity == "OK" ? 0
                 : severity == "WARN"                   ? 1
                 : severity == "STALE"                  ? 3
                                                        : 2;
  status.name = "infuse: " + text_of(report, "device");
  status.message = text_of(report, "what");
  status.hardware_id = text_of(report, "device");
  for (const char* key : {"id", "state", "severity", "advice"})
    status.values.push_back({key, text_of(report, key)});
  ros::DiagnosticArray message;
  message.header.stamp = ros::Time::from(stamp);
  message.status.push_back(std::move(status));
  file.write("/diagnostics", stamp, message);
  return true;
}

bool write_report(const std::string& line, RosFile& file) {
  const auto report = ReportJson::parse(line, nullptr, false);
  if (!report.is_object()) return false;
  const auto stamp = report.find("stamp");
  const std::string kind = text_of(report, "class");
  if (kind != "POSE" && kind != "ALERT") return !kind.empty();
  if (stamp == report.end() || !stamp->is_number_integer()) return false;
  const Stamp time = Stamp::from_ns(stamp->get<int64_t>());
  if (time < Stamp()) return false;
  return kind == "POSE" ? write_pose(report, time, file) : write_alert(report, time, file);
}

}  // namespace

// With ξ = (r, t), the vehicle's position p moves by t + r × p.
std::array<double, 36> to_ros_covariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                         const Eigen::Vector3d& position) {
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J.block<3, 3>(0, 0) << 0, position.z(), -position.y(), -position.z(), 0, position.x(),
      position.y(), -position.x(), 0;
  J.block<3, 3>(0, 3).setIdentity();
  J.block<3, 3>(3, 0).setIdentity();
  std::array<double, 36> result{};
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(result.data()) =
      J * covariance * J.transpose();
  return result;
}

Result<void> write_report_messages(const std::filesystem::path& reports, RosFile& file,
                                   std::vector<Error>& notes) {
  std::ifstream lines(reports);
  if (!lines) return fail("cannot be read", reports.string());
  size_t others = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!write_report(line, file)) ++others;
  }
  if (others > 0)
    notes.push_back({std::to_string(others) + " lines are not reports", reports.string(), ""});
  return {};
}

}  // namespace infuse::daemon
