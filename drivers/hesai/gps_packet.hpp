#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>

#include "drivers/gnss/nmea.hpp"

namespace infuse::hesai {

/// Bytes of a GPS packet's payload (UDP port 10110).
inline constexpr size_t kGpsPacketSize = 512;

/// Content of a GPS packet, which the sensor sends once a second.
struct GpsPacket {
  bool pps_locked = false;
  uint32_t microseconds = 0;  ///< of the sensor's clock within its second
  tl::expected<gnss::NmeaFix, gnss::NmeaFault> sentence;  ///< last sentence of the GNSS receiver
};

/// True if a payload has the size and the mark of a GPS packet: 512 bytes, FF EE.
bool is_gps_packet(std::span<const uint8_t> payload);

/// Parses a payload; nothing if it is no GPS packet.
std::optional<GpsPacket> parse_gps_packet(std::span<const uint8_t> payload);

}  // namespace infuse::hesai
