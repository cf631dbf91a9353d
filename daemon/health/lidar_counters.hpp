#pragma once

#include <cstdint>

#include "daemon/health/source_state.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// Counters of one lidar since the start, at one moment of drive time. They only grow. Plain data,
/// copied between threads.
struct LidarCounters {
  uint64_t packets = 0;           ///< data packets decoded
  uint64_t position_packets = 0;  ///< position packets read
  uint64_t sweeps = 0;            ///< sweeps completed
  uint64_t returns = 0;           ///< returns in those sweeps
  uint64_t dropped_sweeps = 0;    ///< sweeps not processed, because they came too late to it; live

  uint64_t lost_network = 0;  ///< data packets missing by the device's own counter, without those
                              ///< that the kernel dropped
  uint64_t outages = 0;       ///< gaps of a whole turn and longer without packets
  uint64_t lost_in_outages = 0;  ///< of `lost_network`
  uint64_t lost_kernel = 0;      ///< datagrams dropped by the kernel because its buffer was full
  uint64_t malformed = 0;  ///< datagrams on the sensor's ports that are not packets of its model
  const char* malformed_reason = "";  ///< static text: what is wrong with the latest of these
  uint64_t wrong_sender = 0;          ///< datagrams on the sensor's ports from another address
  uint64_t unclaimed = 0;             ///< datagrams to a port of no sensor
  uint64_t wrong_model = 0;     ///< packets that are another model's than the configured one; used
  uint64_t stray_azimuths = 0;  ///< azimuths that cannot be the sensor's; interpolated
  uint64_t duplicates = 0;      ///< repeated data packets; not used
  uint64_t out_of_order = 0;    ///< data packets that arrived late and were reordered
  uint64_t too_late = 0;        ///< data packets that arrived too late to be used
  uint64_t clock_jumps = 0;     ///< jumps of the device's counter

  /// Sweeps decoded with the calibration of another unit (HDL-64E, until its own is known).
  uint64_t uncalibrated_sweeps = 0;
  double turns_hz = 0;          ///< turns per second, by azimuth over the device's time
  bool turns_measured = false;  ///< `turns_hz` is known
  bool two_sensors = false;     ///< packets of two sensors arrive from one address

  Stamp first_packet;  ///< host receive time of the first data packet; valid if packets > 0
  Stamp last_packet;   ///< host receive time of the last data packet; valid if packets > 0
  ClockState clock;    ///< of the device, at its last packet

  SourceState source;  ///< live: state of its socket

  uint32_t sender = 0;           ///< IPv4 address, host order, whose packets are used; 0: none yet
  uint32_t previous_sender = 0;  ///< used before it; 0: none
  uint32_t rival_sender = 0;     ///< another one that sends as much as a sensor now; 0: none
  uint64_t sender_changes = 0;   ///< number of times that another sender was taken

  uint32_t unexpected_sender = 0;  ///< IPv4 address, host order, of the last rejected datagram
  uint32_t unexpected_size = 0;    ///< payload of that datagram, bytes

  /// Number of rejected datagrams: not packets, or of another sensor.
  uint64_t rejected() const { return malformed + wrong_sender + unclaimed; }
};

}  // namespace infuse::daemon
