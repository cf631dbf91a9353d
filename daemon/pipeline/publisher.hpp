#pragma once

#include <functional>
#include <string>
#include <vector>

#include "daemon/pipeline/health_checks.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/pipeline/reports_file.hpp"
#include "daemon/pipeline/totals.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/server/server.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// Turns the items of the fusion thread into messages for the server, the reports file and
/// listeners. Runs on the thread of the `io_context`.
class Publisher {
 public:
  /// Registers as a reader of `in`, which outlives this. `file` may be null.
  Publisher(SlotRing<ReportItem>& in, const SensorSetup& setup, const HealthOptions& health,
            Server& server, ReportsFile* file);

  /// Sets the listener of every pose.
  void set_pose_listener(std::function<void(const PoseReport&)> listener) {
    pose_listener_ = std::move(listener);
  }

  /// Sets who completes every CALIBRATION report before it is published.
  void set_calibration_ledger(std::function<void(CalibrationReport&)> complete) {
    complete_calibration_ = std::move(complete);
  }

  /// Adds a listener of every CALIBRATION report.
  void add_calibration_listener(std::function<void(const CalibrationReport&)> listener) {
    calibration_listeners_.push_back(std::move(listener));
  }

  /// Sets the listener of the start, and of each second of drive time, called when its reports were
  /// published.
  void set_progress_listener(std::function<void()> listener) {
    progress_listener_ = std::move(listener);
  }

  /// Adds a listener of every HEALTH report, with host figures.
  void add_health_listener(std::function<void(const HealthReport&)> listener) {
    health_listeners_.push_back(std::move(listener));
  }

  /// Adds a listener of every ALERT report.
  void add_alert_listener(std::function<void(const AlertReport&)> listener) {
    alert_listeners_.push_back(std::move(listener));
  }

  /// Calls `sink.add(report)` for every ALERT, CALIBRATION and HEALTH report. `sink` outlives this.
  template <class Sink>
  void add_sink(Sink& sink) {
    add_alert_listener([&sink](const AlertReport& report) { sink.add(report); });
    add_calibration_listener([&sink](const CalibrationReport& report) { sink.add(report); });
    add_health_listener([&sink](const HealthReport& report) { sink.add(report); });
  }

  /// Adds a listener of every report, as the server publishes it: (class, device, JSON line).
  void add_line_listener(
      std::function<void(ReportClass, const std::string&, const std::string&)> listener) {
    line_listeners_.push_back(std::move(listener));
  }

  /// Adds a queue of the host to the figures of HEALTH.
  void add_queue(std::function<QueueStats()> stats) { queues_.push_back(std::move(stats)); }

  /// Adds something that is kept on a disk to the figures of HEALTH and to the checks.
  void add_store(std::function<StoreStatus()> status) { stores_.push_back(std::move(status)); }

  /// Sets who asks the PTP clocks at each HEALTH.
  void set_ptp_clocks(std::function<std::vector<PtpClock>()> clocks) {
    ptp_clocks_ = std::move(clocks);
  }

  /// Adds a map in use to the figures of HEALTH and to the checks.
  void add_map(std::function<MapInUse()> map) { maps_.push_back(std::move(map)); }

  /// Sets who asks the host's clock at each HEALTH.
  void set_clock(std::function<std::optional<SystemClock>()> clock) { clock_ = std::move(clock); }

  /// Replaces the thresholds of the health checks.
  void set_health_options(const HealthOptions& health) { checks_.set_options(health); }

  /// Publishes the state of a recording.
  void publish_record(const RecordReport& report);

  /// Publishes an alert about the daemon itself.
  void publish_alert(const AlertReport& alert);

  /// Processes a bounded number of items. Returns true if more are waiting.
  bool drain();

  const Totals& totals() const { return totals_; }
  const HealthChecks& checks() const { return checks_; }

 private:
  void process(const ReportItem& item);
  void start(Stamp stamp);
  void publish_calibration(CalibrationReport report);
  void publish_health(const ReportItem& item);
  void publish_alerts(const std::vector<AlertReport>& alerts);
  template <class Report>
  void publish(const Report& report, const std::string& device);
  void serve(ReportClass report_class, const std::string& device, Stamp stamp, std::string line);
  HostStats host_stats(const ReportItem& item) const;

  SlotRing<ReportItem>& ring_;
  SlotRing<ReportItem>::Reader in_;
  HealthChecks checks_;
  std::function<void()> progress_listener_ = [] {};
  std::function<void(CalibrationReport&)> complete_calibration_ = [](CalibrationReport&) {};
  std::vector<std::function<void(const CalibrationReport&)>> calibration_listeners_;
  std::vector<std::function<void(const HealthReport&)>> health_listeners_;
  std::vector<std::function<void(const AlertReport&)>> alert_listeners_;
  std::function<void(const PoseReport&)> pose_listener_ = [](const PoseReport&) {};
  std::vector<std::function<void(ReportClass, const std::string&, const std::string&)>>
      line_listeners_;
  std::vector<std::function<QueueStats()>> queues_;
  std::vector<std::function<StoreStatus()>> stores_;
  std::vector<std::function<MapInUse()>> maps_;
  std::function<std::optional<SystemClock>()> clock_;
  std::function<std::vector<PtpClock>()> ptp_clocks_;
  Server& server_;
  ReportsFile* file_;
  Totals totals_;
};

}  // namespace infuse::daemon
