#include "drivers/ouster/packet.hpp"

#include <bit>
#include <cstring>
#include <optional>

namespace infuse::ouster {
namespace {

static_assert(std::endian::native == std::endian::little);

/// Maximum duration of a packet; 16 columns of the slowest mode last 3 ms.
constexpr int64_t kMaxPacketNs = 100'000'000;

/// No clock has run for 146 years.
constexpr int64_t kMaxDeviceNs = int64_t{1} << 62;

template <class T>
T read(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Reads the packet's header, or in LEGACY the part of it that each column has.
void read_header(const PacketLayout& layout, const uint8_t* bytes, Packet& packet) {
  if (layout.profile->profile == Profile::kLegacy) {
    packet.frame_id = read<uint16_t>(bytes + 10);
  } else if (layout.fusa_header) {
    packet.initialization_id = read<uint32_t>(bytes) >> 8;
    packet.frame_id = read<uint32_t>(bytes + 4);
    packet.serial_number = read<uint64_t>(bytes + 11) & 0xFF'FFFF'FFFF;
  } else {
    packet.frame_id = read<uint16_t>(bytes + 2);
    packet.initialization_id = read<uint32_t>(bytes + 4) & 0xFF'FFFF;
    packet.serial_number = read<uint64_t>(bytes + 7) & 0xFF'FFFF'FFFF;
  }
}

bool is_lidar_packet(const PacketLayout& layout, const uint8_t* header) {
  if (layout.profile->profile == Profile::kLegacy) return true;
  return layout.fusa_header ? header[0] == 1 : read<uint16_t>(header) == 1;
}

Column read_column(const PacketLayout& layout, const uint8_t* bytes) {
  Column column;
  column.device_ns = static_cast<int64_t>(read<uint64_t>(bytes) & INT64_MAX);
  column.measurement_id = read<uint16_t>(bytes + 8);
  column.pixels = bytes + layout.profile->column_header_bytes();
  if (layout.profile->profile == Profile::kLegacy) {
    column.valid = read<uint32_t>(bytes + layout.column_bytes() - 4) == 0xFFFF'FFFF;
  } else {
    column.valid = (bytes[10] & 1) != 0;
  }
  return column;
}

/// Number of valid columns, or nothing if they do not follow each other in direction (across the
/// turn's beginning too) and time.
std::optional<size_t> count_sequence(const Packet& packet, uint16_t columns_per_turn) {
  const Column* first = nullptr;
  const Column* last = nullptr;
  size_t count = 0;
  for (uint16_t i = 0; i < packet.count; ++i) {
    const Column& column = packet.columns[i];
    if (!column.valid) continue;
    if (column.measurement_id >= columns_per_turn || column.device_ns > kMaxDeviceNs) {
      return std::nullopt;
    }
    if (last != nullptr) {
      const int advance =
          (column.measurement_id - last->measurement_id + columns_per_turn) % columns_per_turn;
      if (advance == 0 || advance > columns_per_turn / 2) return std::nullopt;
      if (column.device_ns <= last->device_ns) return std::nullopt;
      if (column.device_ns - first->device_ns > kMaxPacketNs) return std::nullopt;
    }
    if (first == nullptr) first = &column;
    last = &column;
    ++count;
  }
  return count;
}

/// Reads the heads of a payload of the right size.
void read_heads(const PacketLayout& layout, const uint8_t* payload, Packet& packet) {
  packet.count = layout.columns;
  const uint8_t* bytes = payload + layout.profile->packet_header_bytes();
  const uint8_t* first = nullptr;
  for (uint16_t i = 0; i < packet.count; ++i, bytes += layout.column_bytes()) {
    packet.columns[i] = read_column(layout, bytes);
    if (first == nullptr && packet.columns[i].valid) first = bytes;
  }
  const bool legacy = layout.profile->profile == Profile::kLegacy;
  read_header(layout, legacy && first != nullptr ? first : payload, packet);
}

}  // namespace

const char* describe(PacketFault fault) {
  switch (fault) {
    case PacketFault::kSize:
      return "not the number of bytes that the metadata says";
    case PacketFault::kType:
      return "not a lidar packet by its header";
    case PacketFault::kColumns:
      return "columns that do not follow each other";
  }
  return "";
}

tl::expected<Packet, PacketFault> parse_packet(const PacketLayout& layout,
                                               std::span<const uint8_t> payload) {
  if (payload.size() != layout.packet_bytes()) return tl::unexpected(PacketFault::kSize);
  if (!is_lidar_packet(layout, payload.data())) {
    return tl::unexpected(PacketFault::kType);
  }
  tl::expected<Packet, PacketFault> packet;
  read_heads(layout, payload.data(), *packet);
  if (!count_sequence(*packet, layout.columns_per_turn)) {
    return tl::unexpected(PacketFault::kColumns);
  }
  return packet;
}

std::optional<PacketHead> read_head(std::span<const uint8_t> payload) {
  for (const ProfileInfo& info : kProfiles) {
    for (const uint16_t beams : std::array<uint16_t, 4>{16, 32, 64, 128}) {
      for (const uint16_t columns : std::array<uint16_t, 3>{16, 8, 4}) {
        PacketLayout layout(info, beams, columns, kMaxColumnsPerTurn, false);
        if (payload.size() != layout.packet_bytes()) continue;
        layout.fusa_header = !is_lidar_packet(layout, payload.data());
        if (!is_lidar_packet(layout, payload.data())) continue;
        Packet packet;
        read_heads(layout, payload.data(), packet);
        if (count_sequence(packet, layout.columns_per_turn).value_or(0) < 2) continue;
        const Column* first = packet.columns.data();
        while (!first->valid) ++first;
        return PacketHead{packet.frame_id, packet.serial_number, first->device_ns};
      }
    }
  }
  return std::nullopt;
}

}  // namespace infuse::ouster
