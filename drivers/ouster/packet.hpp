#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>

#include "drivers/ouster/metadata.hpp"
#include "drivers/ouster/profile.hpp"

namespace infuse::ouster {

/// Reason why bytes are not a lidar packet of the layout.
enum class PacketFault : uint8_t {
  kSize,     ///< another number of bytes
  kType,     ///< the header says that it is no lidar packet
  kColumns,  ///< a valid column beyond the turn, or columns that do not follow each other
};

/// Description of the fault for people.
const char* describe(PacketFault fault);

/// Where the columns of a sensor's packets lie.
struct PacketLayout {
  const ProfileInfo* profile;
  uint16_t beams;
  uint16_t columns;           ///< in a packet
  uint16_t columns_per_turn;  ///< measurement ids are smaller
  bool fusa_header;           ///< the packet's header has the layout for functional safety

  PacketLayout(const ProfileInfo& info, uint16_t beam_count, uint16_t packet_columns,
               uint16_t turn_columns, bool has_fusa_header)
      : profile(&info),
        beams(beam_count),
        columns(packet_columns),
        columns_per_turn(turn_columns),
        fusa_header(has_fusa_header) {}

  explicit PacketLayout(const Metadata& metadata)
      : PacketLayout(profile_info(metadata.profile), static_cast<uint16_t>(metadata.beams()),
                     metadata.columns_per_packet, metadata.columns_per_turn, metadata.fusa_header) {
  }

  /// Bytes of a column.
  size_t column_bytes() const {
    return profile->column_header_bytes() + size_t{beams} * profile->pixel_bytes +
           profile->column_footer_bytes();
  }
  /// Bytes of a packet: 1280 … 33 024 with 16 columns.
  size_t packet_bytes() const {
    return 2 * profile->packet_header_bytes() + columns * column_bytes();
  }
};

/// Head of a column; its pixels stay in the payload.
struct Column {
  int64_t device_ns = 0;        ///< of the firing
  uint16_t measurement_id = 0;  ///< number in the turn
  bool valid = false;           ///< false: the sensor did not fire, or lost the data
  const uint8_t* pixels = nullptr;
};

/// Heads of a lidar packet and of its columns.
struct Packet {
  uint32_t frame_id = 0;           ///< number of the turn; 16 bits, FUSA: 32
  uint32_t initialization_id = 0;  ///< 24 bits, changed by each start of the sensor; 0 in LEGACY
  uint64_t serial_number = 0;      ///< 40 bits; 0 in LEGACY
  uint16_t count = 0;              ///< number of columns
  std::array<Column, kMaxColumnsPerPacket> columns;
};

/// Parses the heads of a payload. Columns that are not valid may hold anything. A payload whose
/// columns are all invalid is a packet.
tl::expected<Packet, PacketFault> parse_packet(const PacketLayout& layout,
                                               std::span<const uint8_t> payload);

/// What is known of a lidar packet without metadata.
struct PacketHead {
  uint32_t frame_id = 0;
  uint64_t serial_number = 0;  ///< 0 in LEGACY
  int64_t device_ns = 0;       ///< of the first valid column
};

/// Reads a packet whatever its profile and number of beams. Nothing if the bytes are no Ouster's
/// lidar packet: the size is none of theirs, or fewer than two columns are valid, or they do not
/// follow each other.
std::optional<PacketHead> read_head(std::span<const uint8_t> payload);

}  // namespace infuse::ouster
