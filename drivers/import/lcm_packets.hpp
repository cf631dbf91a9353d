#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/lidar/lidar_maker.hpp"

namespace infuse::importers {

/// A packet of a lidar within a message, whose bytes it refers to.
struct EmbeddedPacket {
  std::span<const uint8_t> payload;
  lidar::PacketClass packet_class = lidar::PacketClass::kOther;
  int64_t time_us = 0;  ///< big-endian number before the packet, if it is a time

  bool is_position() const { return packet_class == lidar::PacketClass::kInformation; }
};

/// Finds the packets of lidars in a message of unknown type, by their content
/// (`lidar::LidarMaker::find_packet`; Velodyne: 12 blocks with flags and azimuths, or an NMEA
/// sentence). The message is the packet, or contains packets that are certain anywhere, others
/// after their length (big-endian, 4 bytes). `time_us` is the number of 8 bytes before the length,
/// or before the packet if it is not after its length.
void find_packets(std::span<const uint8_t> message, std::vector<EmbeddedPacket>& packets);

}  // namespace infuse::importers
