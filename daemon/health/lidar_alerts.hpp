#pragma once

#include <optional>
#include <span>
#include <string>

#include "daemon/health/alert.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/health/lidar_counters.hpp"

namespace infuse::daemon {

/// What the alerts of a lidar are checked by, at one tick.
struct LidarTick {
  const std::string& endpoint;  ///< where its data is received
  const HealthOptions& options;
  const LidarCounters& now;
  const LidarCounters& before;          ///< at the start of the window, at most 10 s ago
  Duration silence;                     ///< since the last packet
  Duration without_sweep;               ///< since the last sweep
  double sweeps_hz;                     ///< over the window
  std::optional<Duration> since_first;  ///< since the first packet; nothing before it
};

/// The alerts of a lidar, the worst first.
std::span<const Alert<LidarTick>> lidar_alerts();

}  // namespace infuse::daemon
