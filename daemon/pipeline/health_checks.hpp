#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "daemon/health/calibration_health.hpp"
#include "daemon/health/lidar_health.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/health/rig_health.hpp"
#include "daemon/health/stream_health.hpp"
#include "daemon/pipeline/pipeline_setup.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// All health checks of the daemon: of each device, each calibration and each task.
class HealthChecks {
 public:
  HealthChecks(const PipelineSetup& setup, const HealthOptions& options);

  /// Starts the checks of the devices.
  void start(Stamp stamp);

  /// Marks the devices whose first data has arrived. Returns true if there are any.
  bool mark_activated_devices(const ReportItem& tick);

  /// Checks everything but calibrations at a tick; `drive`: time since the start. What is raised or
  /// cleared is appended to `alerts`. Host figures are left out.
  HealthReport check(const ReportItem& tick, Duration drive, std::vector<AlertReport>& alerts);

  /// Checks a calibration. What is raised or cleared is appended to `alerts`.
  void check(const CalibrationReport& report, std::vector<AlertReport>& alerts);

  /// Replaces the thresholds.
  void set_options(const HealthOptions& options);

  const std::vector<Device>& devices() const { return devices_; }
  size_t lidar_count() const { return lidar_count_; }

 private:
  void check_devices(const ReportItem& tick, HealthReport& report,
                     std::vector<AlertReport>& alerts);

  std::vector<Device> devices_;
  size_t lidar_count_;  // lidars come first in `devices_`
  HealthOptions options_;
  std::vector<LidarHealth> lidars_;
  std::vector<StreamHealth> streams_;  // of the other devices
  std::vector<std::string> device_names_;
  OdometryHealth odometry_;
  AlertChecks<StreetMapStatus> streetmap_;
  AlertChecks<MapStatus> map_;
  AlertChecks<RigStatus> rig_;
  std::map<std::string, AlertChecks<CalibrationStatus>> calibrations_;  // by camera
};

}  // namespace infuse::daemon
