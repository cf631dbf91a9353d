#include "daemon/ros/report_messages.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/ros/topics.hpp"
#include "drivers/ros/messages.hpp"
#include "drivers/text/text_file.hpp"

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

/// Level of DiagnosticStatus.
uint8_t diagnostic_level(const std::string& level) {
  return level == "OK" ? 0 : level == "WARN" ? 1 : level == "STALE" ? 3 : 2;
}

bool write_alert(const ReportJson& report, Stamp stamp, MessageSink& sink) {
  const std::string severity = text_of(report, "severity");
  const std::string state = text_of(report, "state");
  if (state != "raised" && state != "cleared") return false;
  ros::DiagnosticStatus status;
  status.level = state == "cleared" ? 0 : diagnostic_level(severity);
  status.name = "infuse: " + text_of(report, "device");
  status.message = text_of(report, "what");
  status.hardware_id = text_of(report, "device");
  for (const char* key : {"id", "state", "severity", "advice"})
    status.values.push_back({key, text_of(report, key)});
  ros::DiagnosticArray message;
  message.header.stamp = ros::Time::from(stamp);
  message.status.push_back(std::move(status));
  sink.write(kDiagnosticsTopic, stamp, message);
  return true;
}

/// What HEALTH says about one part: its level, its findings, and its figures.
ros::DiagnosticStatus status_of(const ReportJson& part, const std::string& device) {
  ros::DiagnosticStatus status;
  status.level = diagnostic_level(text_of(part, "level"));
  status.name = "infuse: " + device;
  status.hardware_id = device;
  if (const auto findings = part.find("findings"); findings != part.end()) {
    for (const ReportJson& finding : *findings) {
      if (!finding.is_object()) continue;
      status.message += (status.message.empty() ? "" : "; ") + text_of(finding, "what");
    }
  }
  for (const auto& [key, value] : part.items()) {
    if (key == "device" || key == "level" || value.is_structured()) continue;
    status.values.push_back({key, value.is_string() ? value.get<std::string>() : value.dump()});
  }
  return status;
}

bool write_health(const ReportJson& report, Stamp stamp, MessageSink& sink) {
  ros::DiagnosticArray message;
  message.header.stamp = ros::Time::from(stamp);
  ReportJson daemon = {{"level", text_of(report, "level")}};
  if (const auto findings = report.find("findings"); findings != report.end())
    daemon["findings"] = *findings;
  message.status.push_back(status_of(daemon, "infused"));
  for (const char* group : {"sensors", "streams"}) {
    const auto parts = report.find(group);
    if (parts == report.end() || !parts->is_array()) return false;
    for (const ReportJson& part : *parts) {
      if (!part.is_object()) return false;
      message.status.push_back(status_of(part, text_of(part, "device")));
    }
  }
  if (const auto parts = report.find("calibrations"); parts != report.end() && parts->is_array()) {
    for (const ReportJson& part : *parts) {
      if (!part.is_object()) return false;
      message.status.push_back(status_of(part, text_of(part, "device") + " calibration"));
    }
  }
  for (const char* part : {"odometry", "streetmap", "map"}) {
    const auto found = report.find(part);
    if (found != report.end() && found->is_object())
      message.status.push_back(status_of(*found, part));
  }
  sink.write(kDiagnosticsTopic, stamp, message);
  return true;
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

bool ReportMessages::write_pose(const ReportJson& report, Stamp stamp) {
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
  message.child_frame_id = kVehicleFrame;
  message.pose = ros::to_transform(T_frame_vehicle);
  message.pose_covariance = to_ros_covariance(by_row, T_frame_vehicle.translation());
  message.twist.linear.x = number_of(report, "speed");
  message.twist.angular.z = number_of(report, "yaw_rate");
  sink_.write("/odometry/" + frame, stamp, message);
  if (frame == "odom") {
    sink_.write("/tf", stamp, ros::TfMessage{{{message.header, kVehicleFrame, message.pose}}});
    odometry_ = {stamp, T_frame_vehicle};
  } else if (odometry_ && odometry_->stamp == stamp) {
    const Eigen::Isometry3d T_map_odom = T_frame_vehicle * odometry_->T_odom_vehicle.inverse();
    sink_.write("/tf", stamp,
                ros::TfMessage{{{message.header, "odom", ros::to_transform(T_map_odom)}}});
  }
  return true;
}

bool ReportMessages::write(const std::string& line) {
  const auto report = ReportJson::parse(line, nullptr, false);
  if (!report.is_object()) return false;
  const auto stamp = report.find("stamp");
  const std::string kind = text_of(report, "class");
  if (kind != "POSE" && kind != "ALERT" && kind != "HEALTH") return !kind.empty();
  if (stamp == report.end() || !stamp->is_number_integer()) return false;
  const Stamp time = Stamp::from_ns(stamp->get<int64_t>());
  if (time < Stamp()) return false;
  if (kind == "POSE") return write_pose(report, time);
  return kind == "ALERT" ? write_alert(report, time, sink_) : write_health(report, time, sink_);
}

Result<void> write_report_messages(const std::filesystem::path& reports, MessageSink& sink,
                                   std::vector<Error>& notes) {
  if (const auto regular = text::open_regular_file(reports); !regular) {
    return tl::unexpected(regular.error());
  }
  std::ifstream lines(reports);
  ReportMessages messages(sink);
  size_t others = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!messages.write(line)) ++others;
  }
  if (others > 0)
    notes.push_back({std::to_string(others) + " lines are not reports", reports.string(), ""});
  return {};
}

}  // namespace infuse::daemon
