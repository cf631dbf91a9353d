#pragma once

#include <functional>
#include <string>
#include <vector>

#include "daemon/pipeline/health_checks.hpp"
#include "daemon/pipeline/pipeline_setup.hpp"
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
  Publisher(SlotRing<ReportItem>& in, const PipelineSetup& setup, const HealthOptions& health,
            Server& server, ReportsFile* file);

  /// Sets the listener of every pose.
  void on_pose(std::function<void(const PoseReport&)> listener) { on_pose_ = std::move(listener); }

  /// Adds a listener of every CALIBRATION report.
  void on_calibration(std::function<void(const CalibrationReport&)> listener) {
    on_calibration_.push_back(std::move(listener));
  }

  /// Sets the listener of the start, and of each second of drive time, called when its reports were
  /// published.
  void on_progress(std::function<void()> listener) { on_progress_ = std::move(listener); }

  /// Adds a listener of every HEALTH report, with host figures.
  void on_health(std::function<void(const HealthReport&)> listener) {
    on_health_.push_back(std::move(listener));
  }

  /// Adds a listener of every ALERT report.
  void on_alert(std::function<void(const AlertReport&)> listener) {
    on_alert_.push_back(std::move(listener));
  }

  /// Adds a listener of every report, as the server publishes it.
  void on_line(std::function<void(ReportClass, const std::string&, const std::string&)> listener) {
    on_line_.push_back(std::move(listener));
  }

  /// Adds a queue of the host to the figures of HEALTH.
  void add_queue(std::function<QueueStats()> stats) { queues_.push_back(std::move(stats)); }

  /// Replaces the thresholds of the health checks.
  void set_health_options(const HealthOptions& health) { checks_.set_options(health); }

  /// Publishes the state of a recording.
  void publish_record(const RecordReport& report);

  /// Publishes an alert about the daemon itself.
  void publish_alert(const AlertReport& alert);

  /// Processes a bounded number of items. Returns true if more are waiting.
  bool drain();

  const Totals& totals() const { return totals_; }
  size_t device_count() const { return checks_.devices().size(); }

 private:
  void process(const ReportItem& item);
  void start(Stamp stamp);
  void publish_calibration(const CalibrationReport& report);
  void publish_health(const ReportItem& item);
  void publish_alerts(const std::vector<AlertReport>& alerts);
  template <class Report>
  void publish(const Report& report, const std::string& device);
  void serve(ReportClass report_class, const std::string& device, Stamp stamp, std::string line);
  HostStats host_stats(const ReportItem& item) const;

  SlotRing<ReportItem>& ring_;
  SlotRing<ReportItem>::Reader in_;
  HealthChecks checks_;
  std::function<void()> on_progress_ = [] {};
  std::vector<std::function<void(const CalibrationReport&)>> on_calibration_;
  std::vector<std::function<void(const HealthReport&)>> on_health_;
  std::vector<std::function<void(const AlertReport&)>> on_alert_;
  std::function<void(const PoseReport&)> on_pose_ = [](const PoseReport&) {};
  std::vector<std::function<void(ReportClass, const std::string&, const std::string&)>> on_line_;
  std::vector<std::function<QueueStats()>> queues_;
  Server& server_;
  ReportsFile* file_;
  Totals totals_;
};

/// Returns the processor time of this process, s.
double process_cpu_s();

}  // namespace infuse::daemon
