#include "daemon/health/stream_health.hpp"

namespace infuse::daemon {

StreamHealth::StreamHealth(std::string endpoint, const HealthOptions& options, Stamp start,
                           double max_hz)
    : endpoint_(std::move(endpoint)),
      options_(options),
      max_hz_(max_hz),
      last_received_(start),
      previous_tick_(start),
      window_(start),
      checks_(stream_alerts(), options) {}

const StreamStatus& StreamHealth::update(Stamp now, const StreamCounters& counters) {
  if (now < previous_tick_) {  // drive time stepped back: older counters are not comparable
    window_.restart_at(now, status_.counters);
    last_received_ = now;
  }
  previous_tick_ = now;
  const Window::Snapshot oldest = window_.push(now, counters);
  const double seconds = to_seconds(now - oldest.stamp);
  status_.received_hz =
      seconds > 0 ? static_cast<double>(counters.received - oldest.counters.received) / seconds : 0;
  status_.counters = counters;
  if (counters.received != received_) last_received_ = counters.last;
  received_ = counters.received;
  checks_.update(now, {endpoint_, options_, counters, oldest.counters, now - last_received_,
                       status_.received_hz, max_hz_});
  status_.findings = checks_.findings();
  status_.transitions = checks_.transitions();
  status_.level = checks_.level();
  return status_;
}

}  // namespace infuse::daemon
