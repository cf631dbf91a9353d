#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace infuse::importers {

/// A packet of a Velodyne lidar within a message, whose bytes it refers to.
struct EmbeddedPacket {
  std::span<const uint8_t> payload;  ///< 1206 bytes: data packet; 512: position packet
  int64_t time_us = 0;               ///< big-endian number before the packet, if it is a time

  bool is_position() const;
};

/// Finds the packets of Velodyne lidars in a message of unknown type, by their content: 12 blocks
/// with flags and azimuths, or an NMEA sentence. The message is the packet, or contains data
/// packets anywhere, or position packets after their length (512, big-endian, 4 bytes). `time_us`
/// is the number of 8 bytes before the length, or before the data packet if it is not after its
/// length.
void find_packets(std::span<const uint8_t> message, std::vector<EmbeddedPacket>& packets);

}  // namespace infuse::importers
