#pragma once

#include <array>
#include <cstdint>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {

/// What became of every datagram that a sensor's source saw, by cause. Counts since the start.
struct PacketCounters {
  uint64_t packets = 0;           ///< data packets taken into sweeps
  uint64_t position_packets = 0;  ///< position packets that could be read
  uint64_t network_lost = 0;  ///< data packets missing between two that came, by the device counter
  uint64_t kernel_dropped = 0;  ///< datagrams that the kernel threw away (SO_RXQ_OVFL), told to us
  std::array<uint64_t, 5> malformed{};      ///< data packets refused, by `PacketFault`
  uint64_t malformed_position_packets = 0;  ///< position packets refused
  uint64_t wrong_sender = 0;                ///< from another address than the sensor's: not used
  uint64_t wrong_model = 0;   ///< product byte of another model: used, since the configuration is
                              ///< the authority (early VLP-16 firmware calls itself HDL-32E)
  uint64_t duplicates = 0;    ///< came twice: the second not used
  uint64_t out_of_order = 0;  ///< came late, by one packet: put back in order
  uint64_t too_late = 0;      ///< came later than that: not used
  uint64_t clock_jumps = 0;   ///< times the device's counter jumped (restart, lock to GPS)

  /// Of one cause.
  uint64_t& malformed_by(PacketFault fault) { return malformed[static_cast<size_t>(fault)]; }
  /// Data packets refused because of their bytes.
  uint64_t total_malformed() const {
    uint64_t sum = 0;
    for (const uint64_t count : malformed) sum += count;
    return sum;
  }
};

}  // namespace infuse::velodyne
