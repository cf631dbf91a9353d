#include "daemon/protocol/counters_json.hpp"

#include <cmath>

namespace infuse::daemon {
namespace {

double milliseconds(Duration span) { return rounded(to_seconds(span) * 1e3); }

const char* name_of(ClockState::Source source) {
  switch (source) {
    case ClockState::Source::kNone:
      return "none";
    case ClockState::Source::kHost:
      return "host";
    case ClockState::Source::kPowerUp:
      return "power_up";
    case ClockState::Source::kTopOfHour:
      return "top_of_hour";
  }
  return "none";
}

}  // namespace

double rounded(double value) { return std::round(value * 1000) / 1000; }

Json to_json(const ClockState& clock) {
  Json json = {{"source", name_of(clock.source)},
               {"trusted", clock.trusted},
               {"offset_ns", clock.offset.count()},
               {"jitter_ns", clock.jitter.count()}};
  if (std::isfinite(clock.skew_ppm)) json["skew_ppm"] = rounded(clock.skew_ppm);
  if (!clock.trusted && *clock.reason != '\0') json["reason"] = clock.reason;
  return json;
}

Json losses_json(const SensorCounters& counters) {
  return {{"network", counters.lost_network}, {"kernel", counters.lost_kernel},
          {"malformed", counters.malformed},  {"wrong_sender", counters.wrong_sender},
          {"duplicate", counters.duplicates}, {"too_late", counters.too_late}};
}

Json latency_ms_json(const LatencyStats& latency) {
  return {{"p50", milliseconds(latency.p50)},
          {"p99", milliseconds(latency.p99)},
          {"max", milliseconds(latency.max)}};
}

}  // namespace infuse::daemon
