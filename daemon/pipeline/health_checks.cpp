#include "daemon/pipeline/health_checks.hpp"

namespace infuse::daemon {
namespace {

void append_alerts(Stamp stamp, const std::string& device, std::span<const Transition> transitions,
                   std::vector<AlertReport>& alerts) {
  for (const Transition& transition : transitions) {
    alerts.push_back({stamp, device, transition.raised, transition.finding});
  }
}

/// Updates the health of a task with its status.
template <class Health, class Status>
TaskHealth<Status> check_task(Stamp stamp, const std::string& task, Health& health,
                              const Status& status, std::vector<AlertReport>& alerts) {
  const auto& checks = health.update(stamp, status);
  append_alerts(stamp, task, checks.transitions(), alerts);
  return {status, checks.level(), checks.findings()};
}

}  // namespace

HealthChecks::HealthChecks(const PipelineSetup& setup, const HealthOptions& options)
    : devices_(setup.devices),
      lidar_count_(setup.lidars.size()),
      options_(options),
      odometry_(options),
      streetmap_(streetmap_alerts(), options),
      map_(map_alerts(), options),
      rig_(rig_alerts(), options) {
  for (const Device& device : devices_) device_names_.push_back(device.name);
}

void HealthChecks::start(Stamp stamp) {
  for (size_t i = 0; i < devices_.size(); ++i) {
    if (i < lidar_count_) {
      lidars_.emplace_back(devices_[i].endpoint, options_, stamp);
    } else {
      streams_.emplace_back(devices_[i].endpoint, options_, stamp);
    }
  }
}

bool HealthChecks::mark_activated_devices(const ReportItem& tick) {
  bool any = false;
  for (size_t i = 0; i < devices_.size(); ++i) {
    if (devices_[i].activated) continue;
    const bool lidar = i < lidar_count_;
    if ((lidar ? tick.counters[i].packets : tick.streams[i - lidar_count_].received) == 0) continue;
    devices_[i].activated =
        lidar ? tick.counters[i].first_packet : tick.streams[i - lidar_count_].first;
    any = true;
  }
  return any;
}

HealthReport HealthChecks::check(const ReportItem& tick, Duration drive,
                                 std::vector<AlertReport>& alerts) {
  const Stamp stamp = tick.stamp;
  HealthReport report{.stamp = stamp, .drive = drive};
  check_devices(tick, report, alerts);
  if (tick.odometry.present) {
    report.odometry = check_task(stamp, "odometry", odometry_, tick.odometry, alerts);
  }
  if (tick.streetmap) {
    report.streetmap = check_task(stamp, "streetmap", streetmap_, *tick.streetmap, alerts);
  }
  if (tick.map) report.map = check_task(stamp, "map", map_, *tick.map, alerts);
  for (const auto& [camera, checks] : calibrations_) {
    report.calibrations.push_back({camera, checks.findings()});
  }
  rig_.update(stamp, {device_names_, options_.expected_sensors});
  report.findings = rig_.findings();
  append_alerts(stamp, kDaemonDevice, rig_.transitions(), alerts);
  return report;
}

void HealthChecks::check_devices(const ReportItem& tick, HealthReport& report,
                                 std::vector<AlertReport>& alerts) {
  for (size_t i = 0; i < devices_.size(); ++i) {
    const Device& device = devices_[i];
    if (i < lidar_count_) {
      const LidarStatus& status = lidars_[i].update(tick.stamp, tick.counters[i]);
      report.sensors.push_back({device.name, device.kind, status});
      append_alerts(tick.stamp, device.name, status.transitions, alerts);
    } else {
      const size_t stream = i - lidar_count_;
      const StreamStatus& status = streams_[stream].update(tick.stamp, tick.streams[stream]);
      report.streams.push_back({device.name, device.kind, status});
      append_alerts(tick.stamp, device.name, status.transitions, alerts);
    }
  }
}

void HealthChecks::check(const CalibrationReport& report, std::vector<AlertReport>& alerts) {
  auto& checks =
      calibrations_.try_emplace(report.camera, calibration_alerts(), options_).first->second;
  checks.update(report.stamp, {report.state, report.verdict,
                               report.estimate ? report.estimate->reason : std::string()});
  append_alerts(report.stamp, report.camera, checks.transitions(), alerts);
}

void HealthChecks::set_options(const HealthOptions& options) {
  options_ = options;
  for (LidarHealth& lidar : lidars_) lidar.set_options(options);
  for (StreamHealth& stream : streams_) stream.set_options(options);
}

}  // namespace infuse::daemon
