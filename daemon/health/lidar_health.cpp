#include "daemon/health/lidar_health.hpp"

#include "daemon/health/counting.hpp"

namespace infuse::daemon {

LidarHealth::LidarHealth(std::string endpoint, const HealthOptions& options, Stamp start)
    : endpoint_(std::move(endpoint)),
      options_(options),
      last_packet_(start),
      last_sweep_(start),
      previous_tick_(start),
      window_(start),
      checks_(lidar_alerts(), options) {}

const LidarStatus& LidarHealth::update(Stamp now, const LidarCounters& counters) {
  if (now < previous_tick_) restart_at(now);
  previous_tick_ = now;
  const Window::Snapshot oldest = window_.push(now, counters);
  status_.counters = counters;
  measure_rates(now, oldest);
  note_progress(now, counters);
  std::optional<Duration> since_first;
  if (first_seen_) since_first = now - *first_seen_;
  checks_.update(now, {endpoint_, options_, counters, oldest.counters, now - last_packet_,
                       now - last_sweep_, status_.sweeps_hz, since_first});
  status_.findings = checks_.findings();
  status_.transitions = checks_.transitions();
  status_.level = checks_.level();
  return status_;
}

// Drive time stepped back: older measurements are not comparable.
void LidarHealth::restart_at(Stamp now) {
  window_.restart_at(now, status_.counters);
  last_packet_ = last_sweep_ = now;
}

// Keeps when the last packet and the last sweep came.
void LidarHealth::note_progress(Stamp now, const LidarCounters& counters) {
  if (counters.packets != packets_seen_) last_packet_ = counters.last_packet;
  if (counters.sweeps != sweeps_seen_ || counters.packets == 0) last_sweep_ = now;
  if (counters.packets > 0 && !first_seen_) first_seen_ = now;
  packets_seen_ = counters.packets;
  sweeps_seen_ = counters.sweeps;
}

void LidarHealth::measure_rates(Stamp now, const Window::Snapshot& oldest) {
  const double seconds = to_seconds(now - oldest.stamp);
  const auto rate = [&](uint64_t at_now, uint64_t at_oldest) {
    return seconds > 0 ? static_cast<double>(increase(at_now, at_oldest)) / seconds : 0.0;
  };
  const LidarCounters& c = status_.counters;
  const LidarCounters& b = oldest.counters;
  status_.packets_hz = rate(c.packets, b.packets);
  status_.sweeps_hz = rate(c.sweeps, b.sweeps);
  status_.returns_hz = rate(c.returns, b.returns);
  status_.loss = lost_fraction(
      increase(c.lost_network, b.lost_network) + increase(c.lost_kernel, b.lost_kernel),
      increase(c.packets, b.packets));
}

}  // namespace infuse::daemon
