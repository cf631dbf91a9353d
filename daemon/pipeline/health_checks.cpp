#include "daemon/pipeline/health_checks.hpp"

namespace infuse::daemon {
namespace {

/// Returns what the health check needs of a report.
CalibrationStatus calibration_status(const CalibrationReport& report) {
  const DriftEvidence evidence = report.evidence.value_or(DriftEvidence{});
  CalibrationStatus status{.state = report.state,
                           .axis = evidence.axis,
                           .evidence = evidence.nats,
                           .evidence_threshold = evidence.threshold_nats,
                           .fault = report.fault,
                           .reason = report.estimate ? report.estimate->reason : ""};
  const auto axis = static_cast<Eigen::Index>(monitoring::base_axis(evidence.axis));
  if (axis < report.offset.size()) {
    status.offset = report.offset[axis];
    status.offset_sigma = report.offset_sigma[axis];
  }
  return status;
}

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
  const Conditions& conditions = health.update(stamp, status);
  append_alerts(stamp, task, conditions.transitions(), alerts);
  return {status, conditions.level(), conditions.findings()};
}

}  // namespace

HealthChecks::HealthChecks(const PipelineSetup& setup, const HealthOptions& options)
    : devices_(setup.devices),
      lidar_count_(setup.lidars.size()),
      options_(options),
      odometry_(options),
      streetmap_(options),
      map_(options) {
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
  const Conditions& conditions = rig_.update(stamp, device_names_, options_);
  report.findings = conditions.findings();
  append_alerts(stamp, kDaemonDevice, conditions.transitions(), alerts);
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
  const Conditions& conditions =
      calibrations_[report.camera].update(report.stamp, calibration_status(report));
  append_alerts(report.stamp, report.camera, conditions.transitions(), alerts);
}

void HealthChecks::set_options(const HealthOptions& options) {
  options_ = options;
  for (LidarHealth& lidar : lidars_) lidar.set_options(options);
  for (StreamHealth& stream : streams_) stream.set_options(options);
}

}  // namespace infuse::daemon
