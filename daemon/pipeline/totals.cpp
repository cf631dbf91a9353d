#include "daemon/pipeline/totals.hpp"

namespace infuse::daemon {

void Totals::start_at(Stamp stamp) {
  started = true;
  start = now = stamp;
}

void Totals::count(const SweepReport& report) {
  ++sweeps;
  if (*report.deskew_reason == '\0') {
    ++deskewed_sweeps;
  } else {
    deskew_reason = report.deskew_reason;
  }
}

void Totals::count(const FrameReport& report) {
  ++frames;
  matched_frames += *report.reason == '\0' ? 1 : 0;
}

void Totals::count(const AlertReport& report) {
  constexpr size_t kMaxFirstAlerts = 20;
  if (!report.raised) return;
  ++alerts;
  if (first_alerts.size() < kMaxFirstAlerts) first_alerts.push_back(report);
}

void Totals::update(const ReportItem& tick, const SensorLevels& sensor_levels) {
  now = tick.stamp;
  counters = tick.counters;
  odometry = tick.odometry;
  levels = sensor_levels;
}

}  // namespace infuse::daemon
