#include "daemon/health/stream_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

StreamHealth::StreamHealth(std::string endpoint, const HealthOptions& options, Stamp start)
    : endpoint_(std::move(endpoint)),
      options_(options),
      last_received_(start),
      previous_tick_(start),
      window_(start),
      // Silence has its own timeout: no further delay.
      conditions_{{"silent", Level::kStale, Duration::zero(), Duration::zero()},
                  {"unavailable", Level::kError, Duration::zero(), Duration::zero()},
                  {"bus_off", Level::kError, Duration::zero(), Duration::zero()},
                  {"unreadable", Level::kError, options.raise_after, options.clear_after},
                  {"unused", Level::kError, options.raise_after, options.clear_after},
                  {"loss", Level::kWarn, options.raise_after, options.clear_after},
                  {"bus_errors", Level::kWarn, Duration::zero(), options.clear_after},
                  {"out_of_order", Level::kWarn, Duration::zero(), options.clear_after}} {}

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
  conditions_.update({check_silence(now, counters), check_availability(counters.source),
                      check_bus_off(counters.source), check_readability(counters, oldest.counters),
                      check_use(counters, oldest.counters), check_loss(counters, oldest.counters),
                      check_bus_state(counters.source), check_order(counters, oldest.counters)},
                     now);
  status_.findings = conditions_.findings();
  status_.transitions = conditions_.transitions();
  status_.level = conditions_.level();
  return status_;
}

CheckResult StreamHealth::check_silence(Stamp now, const StreamCounters& counters) {
  if (counters.received != received_) last_received_ = counters.last;
  received_ = counters.received;
  const Duration silence = now - last_received_;
  if (silence < options_.stale_after) return {};
  std::string what = fmt::format("no data from {} for {:.1f} s", endpoint_, to_seconds(silence));
  const uint64_t unread = counters.source.unread_bytes;
  if (unread == 0) return {true, std::move(what), "check power and connection"};
  what += fmt::format("; {} bytes without an RMC or GGA sentence", unread);
  return {true, std::move(what),
          "check baud in [gnss], and that the receiver sends RMC or GGA sentences"};
}

CheckResult StreamHealth::check_readability(const StreamCounters& now,
                                            const StreamCounters& before) const {
  const uint64_t refused = now.refused - before.refused;
  if (refused == 0) return {};
  return {true,
          fmt::format("{} of {} from {} not readable", refused, now.received - before.received,
                      endpoint_),
          "check the data of the sensor or the recording"};
}

// A bus that carries frames, but none of the mapped signals.
CheckResult StreamHealth::check_use(const StreamCounters& now, const StreamCounters& before) const {
  if (!now.source.used || now.received == before.received || now.used > before.used ||
      now.refused - before.refused >= now.received - before.received) {
    return {};
  }
  return {true, fmt::format("no usable data from {}", endpoint_),
          "check the DBC file, the interface and the signal names"};
}

CheckResult StreamHealth::check_loss(const StreamCounters& now,
                                     const StreamCounters& before) const {
  const uint64_t lost = now.lost - before.lost;
  if (lost == 0) return {};
  return {true,
          fmt::format("{} of {} missing from {}", lost, lost + now.received - before.received,
                      endpoint_),
          "reduce the load of the processor or of the link"};
}

CheckResult StreamHealth::check_order(const StreamCounters& now,
                                      const StreamCounters& before) const {
  const uint64_t out_of_order = now.out_of_order - before.out_of_order;
  if (out_of_order == 0) return {};
  return {true, fmt::format("{} stamps of {} out of order", out_of_order, endpoint_),
          "check the clock that stamps the data"};
}

}  // namespace infuse::daemon
