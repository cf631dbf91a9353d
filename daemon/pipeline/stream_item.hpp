#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/health/sensor_counters.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// The host's clock for latencies; never in a report that a replay must repeat.
using HostClock = std::chrono::steady_clock;

/// What the io thread hands to the fusion thread, in the order in which the drive has it. One ring
/// carries all of it, so that what fusion reports is in one order, whatever the threads do.
struct StreamItem {
  enum class Kind : uint8_t {
    kStart,  ///< of the drive; stamp: its first event
    kSweep,  ///< `device` and `sweep`
    kTick,   ///< a second of drive time has passed: `counters`
    kEnd,    ///< of the drive; nothing follows
  };
  Kind kind = Kind::kStart;
  Stamp stamp;
  HostClock::time_point taken;  ///< when the event that completed it was read
  uint32_t device = 0;
  Sweep sweep;
  std::vector<SensorCounters> counters;  ///< by device
  LatencyFigures intake;                 ///< of the io thread, with kTick
};

}  // namespace infuse::daemon
