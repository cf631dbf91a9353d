#include "daemon/health/stream_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

StreamHealth::StreamHealth(std::string endpoint, const HealthOptions& options, Stamp start)
    : endpoint_(std::move(endpoint)),
      options_(options),
      last_received_(start),
      previous_(start),
      window_(start),
      // Silence is a time of its own, so it needs no further delay to be raised.
      conditions_{{"silent", Level::kStale, Duration::zero(), Duration::zero()},
                  {"unavailable", Level::kError, Duration::zero(), Duration::zero()},
                  {"bus_off", Level::kError, Duration::zero(), Duration::zero()},
                  {"unreadable", Level::kError, options.raise_after, options.clear_after},
                  {"unused", Level::kError, options.raise_after, options.clear_after},
                  {"loss", Level::kWarn, options.raise_after, options.clear_after},
                  {"bus", Level::kWarn, Duration::zero(), options.clear_after},
                  {"order", Level::kWarn, Duration::zero(), options.clear_after}} {}

const StreamStatus& StreamHealth::update(Stamp now, const StreamCounters& counters) {
  if (now < previous_) {  // drive time stepped back: nothing old can be compared with it
    window_.restart_at(now, status_.counters);
    last_received_ = now;
  }
  previous_ = now;
  const Window::Snapshot oldest = window_.take(now, counters);
  const double seconds = to_seconds(now - oldest.stamp);
  status_.received_hz =
      seconds > 0 ? static_cast<double>(counters.received - oldest.counters.received) / seconds : 0;
  status_.counters = counters;
  conditions_.judge({judge_silence(now, counters), judge_availability(counters.source),
                     judge_bus_off(counters.source), judge_reading(counters, oldest.counters),
                     judge_use(counters, oldest.counters), judge_loss(counters, oldest.counters),
                     judge_bus(counters.source), judge_order(counters, oldest.counters)},
                    now);
  status_.findings = conditions_.findings();
  status_.transitions = conditions_.transitions();
  status_.level = conditions_.level();
  return status_;
}

Verdict StreamHealth::judge_silence(Stamp now, const StreamCounters& counters) {
  if (counters.received != received_) last_received_ = counters.last;
  received_ = counters.received;
  const Duration silence = now - last_received_;
  if (silence < options_.stale_after) return {};
  return {true, fmt::format("nothing came from {} for {:.1f} s", endpoint_, to_seconds(silence)),
          "check that it has power and is connected"};
}

Verdict StreamHealth::judge_reading(const StreamCounters& now, const StreamCounters& before) const {
  const uint64_t refused = now.refused - before.refused;
  if (refused == 0) return {};
  return {true,
          fmt::format("{} of {} from {} could not be read", refused, now.received - before.received,
                      endpoint_),
          "look at what the sensor or the recording delivers"};
}

// A bus that carries frames, but none of the signals that are mapped.
Verdict StreamHealth::judge_use(const StreamCounters& now, const StreamCounters& before) const {
  if (!now.source.wanted || now.received == before.received || now.used > before.used ||
      now.refused - before.refused >= now.received - before.received) {
    return {};
  }
  return {true, fmt::format("nothing of what came from {} could be used", endpoint_),
          "check the DBC file, the interface and the names of the signals"};
}

Verdict StreamHealth::judge_loss(const StreamCounters& now, const StreamCounters& before) const {
  const uint64_t lost = now.lost - before.lost;
  if (lost == 0) return {};
  return {true,
          fmt::format("{} of {} are missing from {}", lost, lost + now.received - before.received,
                      endpoint_),
          "free processor time, or bandwidth of the link"};
}

Verdict StreamHealth::judge_order(const StreamCounters& now, const StreamCounters& before) const {
  const uint64_t backward = now.backward - before.backward;
  if (backward == 0) return {};
  return {true, fmt::format("{} stamps of {} lay before the one above", backward, endpoint_),
          "check the clock that stamps it"};
}

}  // namespace infuse::daemon
