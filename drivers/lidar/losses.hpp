#pragma once

#include <cstdint>

#include "drivers/lidar/packet_counters.hpp"

namespace infuse::lidar {

/// Divides the packets that are missing by the device's counter into those that the kernel dropped
/// and those that the network lost: the device's counter includes both.
class Losses {
 public:
  /// Counts into `counters`, which must outlive this object.
  explicit Losses(PacketCounters& counters) : counters_(counters) {}

  /// Adds packets missing by the device's counter. `outage`: for a whole turn and longer.
  void add_missing(uint64_t packets, bool outage);

  /// Adds datagrams that the kernel dropped because the receive buffer was full. `data`: at a port
  /// of data packets.
  void add_kernel_dropped(uint64_t datagrams, bool data);

  /// Adds datagrams that the kernel dropped at a port of data packets whose senders it filters,
  /// since the buffer was full or they were not from the sensor: which of them were the sensor's,
  /// its own counter tells.
  void add_filtered(uint64_t datagrams);

 private:
  void settle();

  PacketCounters& counters_;
  uint64_t missing_ = 0;
  uint64_t missing_in_outages_ = 0;
  uint64_t kernel_dropped_ = 0;  ///< at ports of data packets
  bool filtered_ = false;
};

}  // namespace infuse::lidar
