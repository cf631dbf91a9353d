#include "daemon/pipeline/totals.hpp"

namespace infuse::daemon {

void Totals::start_at(Stamp stamp, size_t lidars, size_t streams_after_them) {
  started = true;
  start = now = stamp;
  counters.resize(lidars);
  streams.resize(streams_after_them);
  levels.resize(lidars + streams_after_them);
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

void Totals::update(const ReportItem& tick, const HealthReport& health) {
  now = tick.stamp;
  counters = tick.counters;
  streams = tick.streams;
  odometry = tick.odometry;
  levels.clear();
  for (const auto& sensor : health.sensors) levels.push_back(sensor.status.level);
  for (const auto& stream : health.streams) levels.push_back(stream.status.level);
}

}  // namespace infuse::daemon
