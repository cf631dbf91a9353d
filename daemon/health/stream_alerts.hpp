#pragma once

#include <span>
#include <string>

#include "daemon/health/alert.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/health/stream_counters.hpp"

namespace infuse::daemon {

/// What the alerts of a camera, bus, inertial unit or GNSS receiver are checked by, at one tick.
struct StreamTick {
  const std::string& endpoint;  ///< where its data comes from
  const HealthOptions& options;
  const StreamCounters& now;
  const StreamCounters& before;  ///< at the start of the window, at most 10 s ago
  Duration silence;              ///< since the last data
  double received_hz;            ///< over the window
  double max_hz;                 ///< that such a sensor can send

  /// Number received within the window.
  uint64_t received() const { return now.received - before.received; }
  /// Of these, not readable.
  uint64_t refused() const { return now.refused - before.refused; }
};

/// The alerts of such a stream, the worst first.
std::span<const Alert<StreamTick>> stream_alerts();

}  // namespace infuse::daemon
