#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "daemon/health/calibration_health.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/health/sensor_health.hpp"
#include "daemon/health/stream_health.hpp"
#include "daemon/pipeline/pipeline_setup.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/pipeline/reports_file.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/server/server.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// What a drive came to.
struct Totals {
  bool started = false;  ///< false: the drive was empty
  bool ended = false;
  Stamp start, now;                                       ///< drive time
  uint64_t alerts = 0;                                    ///< findings that were raised
  std::vector<AlertReport> first_alerts;                  ///< the first of these
  std::vector<SensorCounters> counters;                   ///< by lidar
  std::vector<StreamCounters> streams;                    ///< by device that follows the lidars
  OdometryStatus odometry;                                ///< at the last tick
  std::map<std::string, CalibrationReport> calibrations;  ///< the last of each camera
  std::vector<Level> levels;                              ///< by device, at the last tick
  HostStats host;
};

/// Turns the items of the fusion thread into messages: judges health, keeps the totals, tells the
/// server and writes the reports file. On the thread of the `io_context`.
class Publisher {
 public:
  /// Registers as a reader of `in`, which outlives this. `file` may be null.
  Publisher(SlotRing<ReportItem>& in, const PipelineSetup& setup, const HealthOptions& health,
            Server& server, ReportsFile* file);

  /// Calls `listener(const PoseReport&)` for every pose that is told.
  void on_pose(std::function<void(const PoseReport&)> listener) { on_pose_ = std::move(listener); }

  /// Calls `listener(const CalibrationReport&)` for every one that is told.
  void on_calibration(std::function<void(const CalibrationReport&)> listener) {
    on_calibration_ = std::move(listener);
  }

  /// Calls `listener()` when the start, and each second of drive time, has come through the whole
  /// pipeline and was told.
  void on_progress(std::function<void()> listener) { on_progress_ = std::move(listener); }

  /// Calls `listener(message)` for every HEALTH that is told.
  void on_health(std::function<void(const std::string&)> listener) {
    on_health_ = std::move(listener);
  }

  /// Calls `listener(const AlertReport&)` for every one that is told.
  void on_alert(std::function<void(const AlertReport&)> listener) {
    on_alert_ = std::move(listener);
  }

  /// Judges health by these thresholds from now on.
  void set_health_options(const HealthOptions& health);

  /// Tells how a recording stands.
  void publish_record(const RecordReport& report);

  /// Tells that something about the daemon itself is raised or cleared.
  void publish_alert(const AlertReport& alert);

  /// Takes what has come, but not for long. True where more waits.
  bool drain();

  const Totals& totals() const { return totals_; }

 private:
  void process(const ReportItem& item);
  void start(Stamp stamp);
  void publish_sweep(const ReportItem& item);
  void publish_frame(const ReportItem& item);
  void publish_pose(const ReportItem& item);
  void publish_calibration(const CalibrationReport& report);
  void publish_health(const ReportItem& item);
  void update_lidar_health(const ReportItem& item, HealthReport& report);
  void update_stream_health(const ReportItem& item, HealthReport& report);
  bool mark_activated_devices(const ReportItem& item);
  void publish_devices(Stamp stamp);
  void publish_transitions(Stamp stamp, const std::string& device,
                           std::span<const Transition> transitions);
  void publish(ReportClass report_class, const std::string& device, Stamp stamp,
               std::string message);
  HostStats host_stats(const ReportItem& item) const;

  SlotRing<ReportItem>& ring_;
  SlotRing<ReportItem>::Reader in_;
  std::vector<Device> devices_;
  size_t lidar_count_;  // the first of the devices
  bool has_odometry_;
  HealthOptions health_options_;
  std::vector<SensorHealth> lidar_health_;   // of the lidars
  std::vector<StreamHealth> stream_health_;  // of the rest
  OdometryHealth odometry_health_;
  StreetMapHealth streetmap_health_;
  std::map<std::string, CalibrationHealth> calibration_health_;  // by camera
  std::function<void()> on_progress_ = [] {};
  std::function<void(const CalibrationReport&)> on_calibration_ = [](const CalibrationReport&) {};
  std::function<void(const std::string&)> on_health_ = [](const std::string&) {};
  std::function<void(const AlertReport&)> on_alert_ = [](const AlertReport&) {};
  std::function<void(const PoseReport&)> on_pose_ = [](const PoseReport&) {};
  Server& server_;
  ReportsFile* file_;
  Totals totals_;
};

/// Processor time of this process so far, s.
double process_cpu_s();

}  // namespace infuse::daemon
