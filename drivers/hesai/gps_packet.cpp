#include "drivers/hesai/gps_packet.hpp"

#include <string_view>

#include "drivers/lidar/little_endian.hpp"

namespace infuse::hesai {

bool is_gps_packet(std::span<const uint8_t> payload) {
  return payload.size() == kGpsPacketSize && payload[0] == 0xFF && payload[1] == 0xEE;
}

std::optional<GpsPacket> parse_gps_packet(std::span<const uint8_t> payload) {
  // Two bytes FF EE, date and time as six digits each (a second behind the sentence), microseconds,
  // 84 bytes of NMEA, 404 reserved, positioning status, lock of the pulse per second.
  constexpr size_t kMicrosecondsOffset = 14;
  constexpr size_t kSentenceOffset = 18;
  constexpr size_t kSentenceSize = 84;
  constexpr size_t kPpsOffset = 507;
  if (!is_gps_packet(payload)) return std::nullopt;
  GpsPacket packet;
  packet.microseconds = lidar::read_u32(payload.data() + kMicrosecondsOffset);
  packet.pps_locked = payload[kPpsOffset] == 1;
  const auto* sentence = reinterpret_cast<const char*>(payload.data() + kSentenceOffset);
  packet.sentence = gnss::parse_nmea(std::string_view(sentence, kSentenceSize));
  return packet;
}

}  // namespace infuse::hesai
