#pragma once

#include <cstdint>

#include "daemon/health/source_state.hpp"
#include "drivers/lidar/packet_counters.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// Counters of one lidar since the start, at one moment of drive time. They only grow. Plain data,
/// copied between threads.
struct LidarCounters : lidar::PacketCounters {
  uint64_t sweeps = 0;          ///< sweeps completed
  uint64_t returns = 0;         ///< returns in those sweeps
  uint64_t dropped_sweeps = 0;  ///< sweeps not processed, because they came too late to it; live
  uint64_t unclaimed = 0;       ///< datagrams to a port of no sensor

  /// Sweeps decoded with the calibration of another unit (HDL-64E, until its own is known).
  uint64_t uncalibrated_sweeps = 0;

  Stamp first_packet;  ///< host receive time of the first data packet; valid if packets > 0
  Stamp last_packet;   ///< host receive time of the last data packet; valid if packets > 0
  ClockState clock;    ///< of the device, at its last packet

  SourceState source;  ///< live: state of its socket

  /// Number of rejected datagrams: not packets, or of another sensor.
  uint64_t rejected() const { return malformed + wrong_sender + unclaimed; }
};

}  // namespace infuse::daemon
