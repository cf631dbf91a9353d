#pragma once

#include <vector>

#include "daemon/health/sensor_counters.hpp"
#include "daemon/health/stream_counters.hpp"

namespace infuse::daemon {

/// How the live sources are, by device. Of the io thread; empty in a replay.
struct SourceStates {
  std::vector<SourceState> lidars;
  std::vector<SourceState> streams;  ///< as PipelineSetup::devices has them after the lidars
  std::vector<uint64_t> dropped;     ///< by the kernel, by stream

  /// Writes them into the counters that health is judged by.
  void write(std::vector<SensorCounters>& sensor, std::vector<StreamCounters>& stream) const {
    for (size_t i = 0; i < lidars.size(); ++i) sensor[i].source = lidars[i];
    for (size_t i = 0; i < streams.size(); ++i) {
      stream[i].source = streams[i];
      stream[i].lost += dropped[i];
    }
  }
};

}  // namespace infuse::daemon
