#include "daemon/pipeline/publisher.hpp"

#include <algorithm>

#include "daemon/process/process_times.hpp"
#include "daemon/protocol/messages.hpp"
#include "daemon/protocol/names.hpp"

namespace infuse::daemon {

Publisher::Publisher(SlotRing<ReportItem>& in, const SensorSetup& setup,
                     const HealthOptions& health, Server& server, ReportsFile* file)
    : ring_(in),
      in_(in.make_reader()),
      checks_(setup, health),
      server_(server),
      file_(file),
      totals_(setup) {}

template <class Report>
void Publisher::publish(const Report& report, const std::string& device) {
  std::string line = message(report);
  if (file_ != nullptr) file_->write(line);
  serve(Report::kClass, device, report.stamp, std::move(line));
}

void Publisher::serve(ReportClass report_class, const std::string& device, Stamp stamp,
                      std::string line) {
  for (const auto& listener : line_listeners_) listener(report_class, device, line);
  server_.publish(report_class, device, stamp, std::move(line));
}

void Publisher::publish_record(const RecordReport& report) { publish(report, ""); }

bool Publisher::drain() {
  constexpr int kMaxItemsPerDrain = 64;  // then the server handles its clients
  for (int items = 0; items < kMaxItemsPerDrain; ++items) {
    const Pin<ReportItem> item = in_.next();
    if (!item) return false;
    process(*item);
  }
  return true;
}

void Publisher::process(const ReportItem& item) {
  switch (item.kind) {
    case ReportItem::Kind::kStart:
      start(item.stamp);
      return progress_listener_();
    case ReportItem::Kind::kSweep:
      totals_.count(item.sweep);
      return publish(item.sweep, std::string(item.sweep.device));
    case ReportItem::Kind::kPose:
      pose_listener_(item.pose);
      return publish(item.pose, name_of(item.pose.frame));
    case ReportItem::Kind::kFrame:
      totals_.count(item.frame);
      return publish(item.frame, std::string(item.frame.device));
    case ReportItem::Kind::kCalibration:
      return publish_calibration(item.calibration);
    case ReportItem::Kind::kTick:
      if (!totals_.started) start(item.stamp);  // the rest of a drive whose start was overwritten
      publish_health(item);
      return progress_listener_();
    case ReportItem::Kind::kEnd:
      totals_.ended = true;
      return;
  }
}

void Publisher::start(Stamp stamp) {
  totals_.start_at(stamp);
  checks_.start(stamp);
  publish(DevicesReport{stamp, checks_.devices()}, "");
}

void Publisher::publish_calibration(CalibrationReport report) {
  complete_calibration_(report);
  totals_.calibrations[report.camera] = report;
  for (const auto& listener : calibration_listeners_) listener(report);
  publish(report, report.camera);
  std::vector<AlertReport> alerts;
  totals_.calibration_levels[report.camera] = checks_.check(report, alerts);
  publish_alerts(alerts);
}

void Publisher::publish_health(const ReportItem& item) {
  if (checks_.mark_activated(item)) {
    publish(DevicesReport{item.stamp, checks_.devices()}, "");
  }
  std::vector<AlertReport> alerts;
  HealthReport report = checks_.check(item, item.stamp - totals_.start, alerts);
  totals_.update(item, checks_.levels());
  totals_.host = host_stats(item);
  publish_alerts(alerts);
  if (file_ != nullptr) file_->write(message(report));  // without host figures
  alerts.clear();
  const auto& lidars = item.counters.lidars;
  const bool ptp_sensors = std::any_of(lidars.begin(), lidars.end(), [](const auto& lidar) {
    return lidar.clock.source == ClockState::Source::kPtp;
  });
  checks_.check_host({totals_.host.stores, totals_.host.clock, totals_.host.maps,
                      totals_.host.ptp_clocks, ptp_sensors},
                     report, alerts);
  publish_alerts(alerts);
  report.host = totals_.host;
  for (const auto& listener : health_listeners_) listener(report);
  serve(ReportClass::kHealth, "", item.stamp, message(report));
}

void Publisher::publish_alerts(const std::vector<AlertReport>& alerts) {
  for (const AlertReport& alert : alerts) publish_alert(alert);
}

void Publisher::publish_alert(const AlertReport& alert) {
  publish(alert, alert.id());
  for (const auto& listener : alert_listeners_) listener(alert);
  totals_.count(alert);
}

HostStats Publisher::host_stats(const ReportItem& item) const {
  HostStats host;
  host.cpu_s = process_cpu_s();
  for (size_t i = 0; i < item.stages.size(); ++i) {
    const auto stage = static_cast<Stage>(i);
    const uint64_t misses = stage == Stage::kTotal      ? item.deadline_misses
                            : stage == Stage::kRegister ? item.skipped_registrations
                                                        : 0;
    host.stages.push_back({kStageNames[i], item.stages[i], misses});
  }
  host.queues = {item.items_waiting,
                 {"reports", static_cast<uint32_t>(in_.backlog()),
                  static_cast<uint32_t>(ring_.capacity()), in_.lost()}};
  for (const auto& stats : queues_) host.queues.push_back(stats());
  for (const auto& status : stores_) host.stores.push_back(status());
  for (const auto& map : maps_) host.maps.push_back(map());
  if (clock_) host.clock = clock_();
  if (ptp_clocks_) host.ptp_clocks = ptp_clocks_();
  return host;
}

}  // namespace infuse::daemon
