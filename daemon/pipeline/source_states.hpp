#pragma once

#include "daemon/setup/sensor_table.hpp"

namespace infuse::daemon {

/// State of the interface or device of a live sensor that is not a lidar.
struct StreamSource {
  SourceState state;
  uint64_t dropped = 0;  ///< number of items dropped by the kernel
};

/// States of the live sources. Used on the io thread; default in a replay.
struct SourceStates : SensorTable<SourceState, StreamSource> {
  using SensorTable::SensorTable;

  /// Writes them into the counters for health checks.
  void write(SensorCounters& counters) const {
    for (size_t i = 0; i < lidars.size(); ++i) counters.lidars[i].source = lidars[i];
    for (size_t i = 0; i < cameras.size(); ++i) add(cameras[i], counters.cameras[i]);
    for (size_t i = 0; i < buses.size(); ++i) add(buses[i], counters.buses[i]);
    add(speed, counters.speed);
    add(imu, counters.imu);
    add(gnss, counters.gnss);
  }

 private:
  static void add(const StreamSource& source, StreamCounters& counters) {
    counters.source = source.state;
    counters.lost += source.dropped;
  }
};

}  // namespace infuse::daemon
