#pragma once

#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "daemon/health/calibration_health.hpp"
#include "daemon/health/host_alerts.hpp"
#include "daemon/health/lidar_health.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/health/rig_health.hpp"
#include "daemon/health/stream_health.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/setup/sensor_table.hpp"

namespace infuse::daemon {

/// All health checks of the daemon: of each sensor, each calibration and each task.
class HealthChecks {
 public:
  /// `setup` says which sensors there are.
  HealthChecks(const SensorSetup& setup, const HealthOptions& options);

  /// Starts the checks of the sensors.
  void start(Stamp stamp);

  /// Marks the sensors whose first data has arrived. Returns true if there are any.
  bool mark_activated(const ReportItem& tick);

  /// Checks everything but calibrations at a tick; `drive`: time since the start. What is raised or
  /// cleared is appended to `alerts`. Host figures are left out.
  HealthReport check(const ReportItem& tick, Duration drive, std::vector<AlertReport>& alerts);

  /// Checks the host; live only. Its findings are appended to those of the report about the daemon.
  void check_host(const HostStatus& host, HealthReport& report, std::vector<AlertReport>& alerts);

  /// Checks a calibration and returns its level. What is raised or cleared is appended to `alerts`.
  Level check(const CalibrationReport& report, std::vector<AlertReport>& alerts);

  /// Replaces the thresholds.
  void set_options(const HealthOptions& options);

  /// Returns what the sensors are.
  std::vector<Device> devices() const;
  /// Levels of the sensors at the last tick.
  const SensorLevels& levels() const { return levels_; }

  size_t sensor_count() const { return sensors_.size(); }
  /// Number of sensors that are OK.
  size_t ok_sensor_count() const;

 private:
  struct CheckedSensor {
    Sensor sensor;
    std::variant<LidarHealth, StreamHealth> health;
  };

  void check_sensors(const ReportItem& tick, HealthReport& report,
                     std::vector<AlertReport>& alerts);
  void check_lidar(const Sensor& sensor, LidarHealth& health, const ReportItem& tick,
                   HealthReport& report, std::vector<AlertReport>& alerts);
  void check_stream(const Sensor& sensor, StreamHealth& health, const ReportItem& tick,
                    HealthReport& report, std::vector<AlertReport>& alerts);

  HealthOptions options_;
  std::vector<CheckedSensor> sensors_;  // in the order of the reports
  SensorLevels levels_;
  std::vector<std::string> names_;  // of the sensors
  OdometryHealth odometry_;
  AlertChecks<StreetMapStatus> streetmap_;
  AlertChecks<MapStatus> map_;
  AlertChecks<RigStatus> rig_;
  AlertChecks<HostStatus> host_;
  std::map<std::string, AlertChecks<CalibrationStatus>> calibrations_;  // by camera
};

}  // namespace infuse::daemon
