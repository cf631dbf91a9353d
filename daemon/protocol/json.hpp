#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include "daemon/health/latency_histogram.hpp"
#include "daemon/health/lidar_counters.hpp"
#include "daemon/protocol/field.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// JSON whose objects keep the order in which their keys were set.
using Json = nlohmann::ordered_json;

/// The text of a JSON value, on one line or with `indent` spaces a level. Text from files and
/// packets need not be UTF-8: invalid bytes are replaced, and nothing throws.
std::string json_text(const Json& json, int indent = -1);

// Parts of HEALTH that summaries contain too.

/// source, trusted, offset_ns, jitter_ns, and where known skew_ppm and reason.
Json to_json(const ClockState& clock);

/// Datagrams lost or rejected, by cause.
Json losses_json(const LidarCounters& counters);

/// p50, p99, max, milliseconds.
Json latency_ms_json(const LatencyStats& latency);

}  // namespace infuse::daemon
