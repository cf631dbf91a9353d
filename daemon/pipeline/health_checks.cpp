#include "daemon/pipeline/health_checks.hpp"

#include <algorithm>

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

std::variant<LidarHealth, StreamHealth> make_health(const Sensor& sensor,
                                                    const HealthOptions& options, Stamp start) {
  const std::string& endpoint = sensor.device.endpoint;
  if (sensor.id.kind == SensorKind::kLidar) return LidarHealth(endpoint, options, start);
  // The fastest receivers give 100 fixes a second, each by an RMC and a GGA sentence.
  constexpr double kMaxSentencesHz = 250;
  if (sensor.id.kind != SensorKind::kGnss) return StreamHealth(endpoint, options, start);
  return StreamHealth(endpoint, options, start, kMaxSentencesHz);
}

/// Stamp of the first data of a sensor; nothing while there was none.
std::optional<Stamp> first_data(const SensorId& id, const SensorCounters& counters) {
  if (id.kind == SensorKind::kLidar) {
    const LidarCounters& lidar = counters.lidars.at(id.index);
    return lidar.packets > 0 ? std::optional(lidar.first_packet) : std::nullopt;
  }
  const StreamCounters& stream = counters.stream(id);
  return stream.received > 0 ? std::optional(stream.first) : std::nullopt;
}

}  // namespace

HealthChecks::HealthChecks(const SensorSetup& setup, const HealthOptions& options)
    : options_(options),
      levels_(setup),
      odometry_(options),
      streetmap_(streetmap_alerts(), options),
      map_(map_alerts(), options),
      rig_(rig_alerts(), options),
      host_(host_alerts(), options) {
  for (const Sensor& sensor : setup.sensors()) {
    names_.push_back(sensor.device.name);
    sensors_.push_back({sensor, make_health(sensor, options, Stamp())});
  }
}

void HealthChecks::start(Stamp stamp) {
  for (CheckedSensor& checked : sensors_) {
    checked.health = make_health(checked.sensor, options_, stamp);
  }
}

std::vector<Device> HealthChecks::devices() const {
  std::vector<Device> devices;
  for (const CheckedSensor& checked : sensors_) devices.push_back(checked.sensor.device);
  return devices;
}

size_t HealthChecks::ok_sensor_count() const {
  return static_cast<size_t>(
      std::count_if(sensors_.begin(), sensors_.end(), [&](const CheckedSensor& checked) {
        return level_of(checked.sensor.id, levels_) == Level::kOk;
      }));
}

bool HealthChecks::mark_activated(const ReportItem& tick) {
  bool any = false;
  for (CheckedSensor& checked : sensors_) {
    Device& device = checked.sensor.device;
    if (device.activated) continue;
    device.activated = first_data(checked.sensor.id, tick.counters);
    any = any || device.activated;
  }
  return any;
}

HealthReport HealthChecks::check(const ReportItem& tick, Duration drive,
                                 std::vector<AlertReport>& alerts) {
  const Stamp stamp = tick.stamp;
  HealthReport report{.stamp = stamp, .drive = drive};
  check_sensors(tick, report, alerts);
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
  rig_.update(stamp, {names_, options_.expected_sensors});
  report.findings = rig_.findings();
  append_alerts(stamp, kDaemonDevice, rig_.transitions(), alerts);
  return report;
}

void HealthChecks::check_host(const HostStatus& host, HealthReport& report,
                              std::vector<AlertReport>& alerts) {
  host_.update(report.stamp, host);
  report.findings.insert(report.findings.end(), host_.findings().begin(), host_.findings().end());
  append_alerts(report.stamp, kDaemonDevice, host_.transitions(), alerts);
}

void HealthChecks::check_sensors(const ReportItem& tick, HealthReport& report,
                                 std::vector<AlertReport>& alerts) {
  for (CheckedSensor& checked : sensors_) {
    if (auto* lidar = std::get_if<LidarHealth>(&checked.health)) {
      check_lidar(checked.sensor, *lidar, tick, report, alerts);
    } else if (auto* stream = std::get_if<StreamHealth>(&checked.health)) {
      check_stream(checked.sensor, *stream, tick, report, alerts);
    }
  }
}

void HealthChecks::check_lidar(const Sensor& sensor, LidarHealth& health, const ReportItem& tick,
                               HealthReport& report, std::vector<AlertReport>& alerts) {
  const size_t lidar = sensor.id.index;
  const LidarStatus& status = health.update(tick.stamp, tick.counters.lidars.at(lidar));
  levels_.lidars[lidar] = status.level;
  report.sensors.push_back({sensor.device.name, sensor.device.kind, status});
  append_alerts(tick.stamp, sensor.device.name, status.transitions, alerts);
}

void HealthChecks::check_stream(const Sensor& sensor, StreamHealth& health, const ReportItem& tick,
                                HealthReport& report, std::vector<AlertReport>& alerts) {
  const StreamStatus& status = health.update(tick.stamp, tick.counters.stream(sensor.id));
  levels_.stream(sensor.id) = status.level;
  report.streams.push_back({sensor.device.name, sensor.device.kind, status});
  append_alerts(tick.stamp, sensor.device.name, status.transitions, alerts);
}

Level HealthChecks::check(const CalibrationReport& report, std::vector<AlertReport>& alerts) {
  auto& checks =
      calibrations_.try_emplace(report.camera, calibration_alerts(), options_).first->second;
  checks.update(report.stamp, {report.state, report.verdict,
                               report.estimate ? report.estimate->reason : std::string()});
  append_alerts(report.stamp, report.camera, checks.transitions(), alerts);
  return checks.level();
}

void HealthChecks::set_options(const HealthOptions& options) {
  options_ = options;
  for (CheckedSensor& checked : sensors_) {
    std::visit([&](auto& health) { health.set_options(options); }, checked.health);
  }
}

}  // namespace infuse::daemon
