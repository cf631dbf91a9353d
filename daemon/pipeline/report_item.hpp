#pragma once

#include <cstdint>
#include <vector>

#include "daemon/health/sensor_counters.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What the fusion thread hands to the thread that tells: values of fixed size, not yet text.
struct ReportItem {
  StreamItem::Kind kind = StreamItem::Kind::kStart;
  Stamp stamp;
  SweepReport sweep;                     ///< with kSweep
  std::vector<SensorCounters> counters;  ///< with kTick; by device
  LatencyFigures intake;                 ///< with kTick; an event read to its sweep handed over
  LatencyFigures fusion;                 ///< with kTick; a sweep taken to its report
  LatencyFigures whole;                  ///< with kTick; an event read to the sweep's report
  uint64_t deadline_misses = 0;          ///< sweeps whose `whole` was above the budget
  QueueFigures sweeps_waiting;           ///< with kTick
};

}  // namespace infuse::daemon
