#pragma once

#include <map>
#include <optional>
#include <string>

#include "daemon/config/mqtt_settings.hpp"
#include "daemon/mqtt/report_queue.hpp"
#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// Selects what the broker gets, and its topic: all alerts, calibrations when they change, health
/// and poses at intervals. Payloads are the lines of the socket (`daemon/protocol`).
class ReportTopics {
 public:
  explicit ReportTopics(const MqttSettings& settings);

  std::optional<QueuedReport> select(const AlertReport& report);
  std::optional<QueuedReport> select(const CalibrationReport& report);
  std::optional<QueuedReport> select(const HealthReport& report);
  std::optional<QueuedReport> select(const PoseReport& report);

 private:
  std::string topic(const std::string& path) const { return root_ + path; }

  std::string root_;
  Duration pose_interval_, health_interval_;
  std::map<std::string, std::string> calibrations_;  // what was published last, by camera
  std::map<std::string, Stamp> poses_;               // published last, by frame
  std::optional<Stamp> health_;                      // published last …
  Level health_level_ = Level::kOk;                  // … and its level
};

/// Topic of the vehicle's presence, which the broker itself changes when the vehicle is lost.
std::string status_topic(const MqttSettings& settings);

/// One level of a topic: separators, wildcards and control characters are replaced by _.
std::string topic_level(std::string name);

}  // namespace infuse::daemon
