#include "daemon/mqtt/report_topics.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/protocol/messages.hpp"
#include "daemon/protocol/names.hpp"

namespace infuse::daemon {
namespace {

// Of a full queue the poses are dropped first, alerts last.
enum Importance { kPoseImportance, kHealthImportance, kCalibrationImportance, kAlertImportance };

/// What a change of the calibration is: its state, its extrinsics, or its fault.
std::string calibration_key(const CalibrationReport& report) {
  std::string key = fmt::format("{} {}", monitoring::name_of(report.state),
                                monitoring::name_of(report.verdict.fault));
  for (int i = 0; i < 12; ++i) {
    key += fmt::format(" {}", report.T_camera_lidar.matrix()(i / 4, i % 4));
  }
  return key;
}

/// True once in an interval; also where time runs backwards.
bool is_due(const std::optional<Stamp>& last, Stamp now, Duration interval) {
  return !last || now - *last >= interval || now < *last;
}

}  // namespace

std::string topic_level(std::string name) {
  for (char& each : name) {
    const auto byte = static_cast<unsigned char>(each);
    if (byte < 0x20 || byte == 0x7f || each == '/' || each == '+' || each == '#') each = '_';
  }
  return name;
}

std::string status_topic(const MqttSettings& settings) {
  return settings.topic + "/" + settings.vehicle + "/status";
}

ReportTopics::ReportTopics(const MqttSettings& settings)
    : root_(settings.topic + "/" + settings.vehicle + "/"),
      pose_interval_(settings.pose_interval),
      health_interval_(settings.health_interval) {}

std::optional<QueuedReport> ReportTopics::select(const AlertReport& report) {
  return QueuedReport{.importance = kAlertImportance,
                      .topic = topic("alert/" + topic_level(report.id())),
                      .payload = message(report),
                      .retain = true};
}

std::optional<QueuedReport> ReportTopics::select(const CalibrationReport& report) {
  const std::string key = calibration_key(report);
  std::string& published = calibrations_[report.camera];
  if (published == key) return std::nullopt;
  published = key;
  return QueuedReport{.importance = kCalibrationImportance,
                      .topic = topic("calibration/" + topic_level(report.camera)),
                      .payload = message(report),
                      .retain = true};
}

std::optional<QueuedReport> ReportTopics::select(const HealthReport& report) {
  const bool changed = report.level() != health_level_;
  if (!changed && !is_due(health_, report.stamp, health_interval_)) return std::nullopt;
  health_ = report.stamp;
  health_level_ = report.level();
  return QueuedReport{.importance = kHealthImportance,
                      .topic = topic("health"),
                      .payload = message(report),
                      .retain = true};
}

std::optional<QueuedReport> ReportTopics::select(const PoseReport& report) {
  if (pose_interval_ == Duration{0}) return std::nullopt;
  const std::string frame = name_of(report.frame);
  const auto last = poses_.find(frame);
  if (last != poses_.end() && !is_due(last->second, report.stamp, pose_interval_)) {
    return std::nullopt;
  }
  poses_[frame] = report.stamp;
  return QueuedReport{.importance = kPoseImportance,
                      .topic = topic("pose/" + frame),
                      .payload = message(report),
                      .retain = false};
}

}  // namespace infuse::daemon
