#pragma once

#include <vector>

#include "daemon/health/lidar_counters.hpp"
#include "daemon/health/stream_counters.hpp"

namespace infuse::daemon {

/// States of the live sources. Used on the io thread; empty in a replay.
struct SourceStates {
  std::vector<SourceState> lidars;   ///< by LidarIndex
  std::vector<SourceState> streams;  ///< in the order of PipelineSetup::devices after the lidars
  std::vector<uint64_t> dropped;     ///< number of items dropped by the kernel, by stream

  /// Writes them into the counters for health checks.
  void write(std::vector<LidarCounters>& sensor, std::vector<StreamCounters>& stream) const {
    for (size_t i = 0; i < lidars.size(); ++i) sensor[i].source = lidars[i];
    for (size_t i = 0; i < streams.size(); ++i) {
      stream[i].source = streams[i];
      stream[i].lost += dropped[i];
    }
  }
};

}  // namespace infuse::daemon
