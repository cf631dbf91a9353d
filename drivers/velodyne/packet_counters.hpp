#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {

/// Number of datagrams of a sensor's source by outcome, since the start.
struct PacketCounters {
  uint64_t packets = 0;           ///< data packets decoded into sweeps
  uint64_t position_packets = 0;  ///< valid position packets
  /// Data packets missing between two received ones, by the device counter.
  uint64_t network_lost = 0;
  uint64_t outages = 0;          ///< gaps without packets of a whole turn and longer
  uint64_t lost_in_outages = 0;  ///< of `network_lost`
  uint64_t kernel_dropped = 0;   ///< datagrams dropped by the kernel (SO_RXQ_OVFL), as reported
  std::array<uint64_t, 5> malformed{};      ///< data packets refused, by `PacketFault`
  uint64_t malformed_position_packets = 0;  ///< position packets refused
  uint64_t stray_azimuths = 0;  ///< impossible or out of line with their neighbours: interpolated
  uint64_t wrong_sender = 0;    ///< from another address than the sensor's: not used
  uint64_t duplicates = 0;      ///< received twice: the second not used
  uint64_t out_of_order = 0;    ///< late by one packet: put back in order
  uint64_t too_late = 0;        ///< later than that: not used
  uint64_t clock_jumps = 0;     ///< jumps of the device's counter (restart, GPS lock)

  std::optional<PacketFault> last_fault;  ///< of the latest refused data packet

  /// Counts a refused data packet.
  void count_malformed(PacketFault fault) {
    ++malformed[static_cast<size_t>(fault)];
    last_fault = fault;
  }
  /// Number of data packets refused because of their bytes.
  uint64_t total_malformed() const {
    uint64_t sum = 0;
    for (const uint64_t count : malformed) sum += count;
    return sum;
  }
};

}  // namespace infuse::velodyne
