#include "daemon/history/history_writer.hpp"

namespace infuse::daemon {

void HistoryWriter::add(const AlertReport& alert) {
  if (!alert.raised || alerts_[alert.id()]++ > 0) return;
  write({{"form", kHistoryForm},
         {"class", "ALERT"},
         {"stamp", alert.stamp.ns()},
         {"id", alert.id()},
         {"severity", name_of(alert.finding.level)},
         {"what", alert.finding.what}});
}

void HistoryWriter::add(const CalibrationReport& report) {
  const auto written = calibrations_.find(report.camera);
  if (written != calibrations_.end() &&
      written->second.matrix() == report.T_camera_lidar.matrix()) {
    return;
  }
  Json T = Json::array();
  for (int i = 0; i < 16; ++i) T.push_back(report.T_camera_lidar.matrix()(i / 4, i % 4));
  write({{"form", kHistoryForm},
         {"class", "CALIBRATION"},
         {"stamp", report.stamp.ns()},
         {"device", report.camera},
         {"state", monitoring::name_of(report.state)},
         {"T_camera_lidar", T}});
  calibrations_[report.camera] = report.T_camera_lidar;
}

void HistoryWriter::add(const HealthReport& health) {
  write_waiting();
  const bool over = sums_ && (health.stamp - sums_->from >= kPeriod || health.stamp < sums_->from);
  if (over) write_summary();
  if (!sums_) sums_.emplace().from = health.stamp;
  sums_->to = health.stamp;
  ++sums_->seconds[name_of(health.level())];
  for (const auto& sensor : health.sensors) {
    const LidarCounters& c = sensor.status.counters;
    now_[sensor.device] = {c.sweeps, c.lost_network + c.lost_kernel};
  }
}

void HistoryWriter::finish() {
  if (sums_) write_summary();
}

void HistoryWriter::write_summary() {
  Json seconds = Json::object(), sensors = Json::object(), alerts = Json::object();
  for (const auto& [level, count] : sums_->seconds) seconds[level] = count;
  for (const auto& [device, now] : now_) {
    const Sensor before = std::exchange(written_[device], now);
    sensors[device] = {{"sweeps", now.sweeps - std::min(now.sweeps, before.sweeps)},
                       {"lost", now.lost - std::min(now.lost, before.lost)}};
  }
  for (const auto& [id, count] : alerts_) alerts[id] = count;
  write({{"form", kHistoryForm},
         {"class", "HEALTH"},
         {"stamp", sums_->from.ns()},
         {"until", sums_->to.ns()},
         {"seconds", seconds},
         {"sensors", sensors},
         {"alerts", alerts}});
  sums_.reset();
  alerts_.clear();
}

void HistoryWriter::write(const Json& entry) {
  if (!enabled_) return;
  if (waiting_.size() == kMaxWaiting) {
    waiting_.pop_front();
    ++lost_;
  }
  waiting_.push_back(json_text(entry));
  write_waiting();
}

void HistoryWriter::write_waiting() {
  for (; !waiting_.empty(); waiting_.pop_front()) {
    const auto written = file_.append(waiting_.front());
    problem_ = written ? ""
               : lost_ == 0
                   ? written.error().message()
                   : written.error().message() + "; " + std::to_string(lost_) + " lines lost";
    if (!written) return;
  }
}

}  // namespace infuse::daemon
