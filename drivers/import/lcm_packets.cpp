#include "drivers/import/lcm_packets.hpp"

#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/position_packet.hpp"

namespace infuse::importers {
namespace {

constexpr size_t kSentencePlace = 0xCE;  // of a position packet

bool is_block_flag(const uint8_t* bytes) {
  return bytes[0] == 0xFF &&
         (bytes[1] == 0xEE || bytes[1] == 0xDD || bytes[1] == 0xCC || bytes[1] == 0xBB);
}

/// True if bytes are a data packet of any model: all flags, most azimuths.
bool is_data_packet(std::span<const uint8_t> payload) {
  size_t azimuths = 0;
  for (size_t block = 0; block < velodyne::kBlocks; ++block) {
    const uint8_t* bytes = payload.data() + block * velodyne::kBlockSize;
    if (!is_block_flag(bytes)) return false;
    if (velodyne::read_u16(bytes + 2) <= velodyne::kCentidegreesPerTurn) ++azimuths;
  }
  return azimuths > velodyne::kBlocks / 2;
}

bool is_position_packet(std::span<const uint8_t> payload) {
  return payload[kSentencePlace] == '$' && velodyne::parse_position_packet(payload).has_value();
}

/// The number of so many bytes before `at`, big-endian; 0 if there is no room.
int64_t number_before(std::span<const uint8_t> message, size_t at, size_t bytes) {
  if (at < bytes) return 0;
  uint64_t value = 0;
  for (size_t k = at - bytes; k < at; ++k) value = value << 8 | message[k];
  return static_cast<int64_t>(value);
}

/// Whether the length of a packet is before it.
bool has_length(std::span<const uint8_t> message, size_t at, size_t size) {
  return number_before(message, at, 4) == static_cast<int64_t>(size);
}

}  // namespace

bool EmbeddedPacket::is_position() const { return payload.size() == velodyne::kPositionPacketSize; }

void find_packets(std::span<const uint8_t> message, std::vector<EmbeddedPacket>& packets) {
  packets.clear();
  if (message.size() == velodyne::kPositionPacketSize && is_position_packet(message)) {
    packets.push_back({message});
    return;
  }
  for (size_t at = 0; at + velodyne::kPositionPacketSize <= message.size();) {
    const bool has_room = at + velodyne::kPacketSize <= message.size();
    if (has_room && is_block_flag(message.data() + at)) {
      const auto payload = message.subspan(at, velodyne::kPacketSize);
      if (is_data_packet(payload)) {
        const size_t length = has_length(message, at, velodyne::kPacketSize) ? 4 : 0;
        packets.push_back({payload, number_before(message, at - length, 8)});
        at += velodyne::kPacketSize;
        continue;
      }
    }
    if (at >= 4 && message[at + kSentencePlace] == '$' &&
        has_length(message, at, velodyne::kPositionPacketSize)) {
      const auto payload = message.subspan(at, velodyne::kPositionPacketSize);
      if (is_position_packet(payload)) {
        packets.push_back({payload, number_before(message, at - 4, 8)});
        at += velodyne::kPositionPacketSize;
        continue;
      }
    }
    ++at;
  }
}

}  // namespace infuse::importers
