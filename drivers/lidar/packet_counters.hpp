#pragma once

#include <cstdint>

namespace infuse::lidar {

/// Number of datagrams of one lidar by outcome since the start, and what its packets show of it.
/// They only grow. Plain data.
struct PacketCounters {
  uint64_t packets = 0;           ///< data packets decoded
  uint64_t position_packets = 0;  ///< information packets read (Velodyne: position packets)
  uint64_t lost_network = 0;  ///< data packets missing by the device's own counter, without those
                              ///< that the kernel dropped
  uint64_t outages = 0;       ///< gaps of a whole turn and longer without packets
  uint64_t lost_in_outages = 0;  ///< of `lost_network`
  uint64_t lost_kernel = 0;      ///< datagrams dropped by the kernel because its buffer was full
  uint64_t malformed = 0;  ///< datagrams on the sensor's ports that are not packets of its model
  const char* malformed_reason = "";  ///< static text: what is wrong with the latest of these
  uint64_t wrong_sender = 0;          ///< datagrams on the sensor's ports from another address
  uint64_t wrong_model = 0;     ///< packets that are another model's than the configured one; used
  uint64_t stray_azimuths = 0;  ///< azimuths that cannot be the sensor's; interpolated
  uint64_t duplicates = 0;      ///< repeated data packets; not used
  uint64_t out_of_order = 0;    ///< data packets that arrived late and were reordered
  uint64_t too_late = 0;        ///< data packets that arrived too late to be used
  uint64_t clock_jumps = 0;     ///< jumps of the device's counter

  double turns_hz = 0;          ///< turns per second, by azimuth over the device's time
  bool turns_measured = false;  ///< `turns_hz` is known
  bool two_sensors = false;     ///< packets of two sensors arrive from one address

  uint32_t sender = 0;           ///< IPv4 address, host order, whose packets are used; 0: none yet
  uint32_t previous_sender = 0;  ///< used before it; 0: none
  uint32_t rival_sender = 0;     ///< another one that sends as much as a sensor now; 0: none
  uint64_t sender_changes = 0;   ///< number of times that another sender was taken

  uint32_t unexpected_sender = 0;  ///< IPv4 address, host order, of the last rejected datagram
  uint32_t unexpected_size = 0;    ///< payload of that datagram, bytes
};

}  // namespace infuse::lidar
