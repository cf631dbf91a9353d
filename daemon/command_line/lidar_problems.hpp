#pragma once

#include <string>
#include <vector>

#include "daemon/health/level.hpp"
#include "daemon/health/lidar_counters.hpp"
#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// What is wrong with the recorded packets of a lidar, however short the recording is.
struct LidarProblem {
  Level level = Level::kWarn;
  std::string what;  ///< "lidar: 12 packets lost"
};

/// Finds the problems of a lidar by its counters at the end of a recording.
std::vector<LidarProblem> find_problems(const Device& device, const LidarCounters& counters);

/// Level of the worst problem, and at least `level`.
Level worst_level(Level level, const std::vector<LidarProblem>& problems);

/// ", 300 of them in 2 outages of a turn and longer" if the lidar's packets paused so long; what is
/// lost then was not recorded or not sent, rather than lost among others.
std::string outages_text(const LidarCounters& counters);

/// Time from the first packet to the last.
Duration active_duration(const LidarCounters& counters);

/// Turns per second by azimuth, if packets show them; else sweeps per second.
double sweep_rate(const LidarCounters& counters);

}  // namespace infuse::daemon
