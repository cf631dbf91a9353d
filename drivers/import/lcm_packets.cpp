#include "drivers/import/lcm_packets.hpp"

#include "drivers/makers/makers.hpp"

namespace infuse::importers {
namespace {

/// The packet of any maker with which bytes begin.
std::optional<lidar::FoundPacket> find_packet(std::span<const uint8_t> bytes) {
  for (const lidar::LidarMaker* maker : makers::all()) {
    if (auto found = maker->find_packet(bytes)) return found;
  }
  return std::nullopt;
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

void find_packets(std::span<const uint8_t> message, std::vector<EmbeddedPacket>& packets) {
  packets.clear();
  for (size_t at = 0; at < message.size();) {
    const auto found = find_packet(message.subspan(at));
    const bool whole = found && found->size == message.size();
    const bool has_own_length = found && has_length(message, at, found->size);
    if (!found || !(found->certain || whole || has_own_length)) {
      ++at;
      continue;
    }
    const size_t length = has_own_length ? 4 : 0;
    packets.push_back({message.subspan(at, found->size), found->packet_class,
                       number_before(message, at - length, 8)});
    at += found->size;
  }
}

}  // namespace infuse::importers
