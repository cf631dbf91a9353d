#pragma once

#include <cstdint>

#include "daemon/health/source_state.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// What one lidar has delivered since the start, at one moment of drive time. Every number only
/// grows. Plain data: it is copied from the io thread to whoever judges it.
struct SensorCounters {
  uint64_t packets = 0;           ///< data packets decoded
  uint64_t position_packets = 0;  ///< position packets read
  uint64_t sweeps = 0;            ///< sweeps completed
  uint64_t returns = 0;           ///< returns in those sweeps

  uint64_t lost_network = 0;  ///< data packets missing by the device's own counter, without those
                              ///< that the kernel dropped
  uint64_t lost_kernel = 0;   ///< datagrams that the kernel dropped for want of buffer
  uint64_t malformed = 0;     ///< datagrams on the sensor's ports that are no packet of its model
  uint64_t wrong_sender = 0;  ///< datagrams on the sensor's ports from another address
  uint64_t unclaimed = 0;     ///< datagrams that came to no sensor's port
  uint64_t wrong_model = 0;   ///< packets that name another model than the configured one; used
  uint64_t duplicates = 0;    ///< data packets that came twice; the second not used
  uint64_t out_of_order = 0;  ///< data packets that came late and were put back in order
  uint64_t too_late = 0;      ///< data packets that came too late to be used
  uint64_t clock_jumps = 0;   ///< times the device's counter jumped

  Stamp first_packet;  ///< host receive time of the first data packet; meaningful when packets > 0
  Stamp last_packet;   ///< and of the last
  ClockState clock;    ///< of the device, as it was last stated

  SourceState source;  ///< live: of its socket

  uint32_t unexpected_sender = 0;  ///< IPv4 address, host order, of the last datagram not taken
  uint32_t unexpected_size = 0;    ///< its payload, bytes

  /// Datagrams that were not taken: as they are no packet, or not this sensor's.
  uint64_t rejected() const { return malformed + wrong_sender + unclaimed; }
};

}  // namespace infuse::daemon
