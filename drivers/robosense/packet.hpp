#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>

#include "drivers/measurement/sweep.hpp"
#include "drivers/robosense/model.hpp"

namespace infuse::robosense {

/// Bytes of a payload, of data packets (MSOP) and information packets (DIFOP).
inline constexpr size_t kPacketSize = 1248;
/// Bytes before the first block of a data packet.
inline constexpr size_t kHeaderSize = 42;
/// Number of blocks of a data packet.
inline constexpr size_t kBlocks = 12;
/// Bytes of a block: FF EE, azimuth, 32 units.
inline constexpr size_t kBlockSize = 100;
/// Bytes of a block before its units.
inline constexpr size_t kBlockPrefix = 4;
/// Bytes of a unit: distance, reflectivity.
inline constexpr size_t kUnitSize = 3;

/// Returns that a sensor sends; the values of an information packet's return mode.
enum class ReturnMode : uint8_t { kDual = 0, kStrongest = 4, kLast = 5, kFirst = 6 };

/// Reason why bytes are not a data packet.
enum class PacketFault : uint8_t {
  kSize,     ///< not 1248 bytes
  kHeader,   ///< does not begin as those of a supported model do
  kFlag,     ///< a block does not begin with FF EE
  kAzimuth,  ///< most azimuths are above 360°
  kTime,     ///< a second has no such microsecond, or the time is impossibly late
};

/// Description of the fault for people.
const char* describe(PacketFault fault);

/// Header of a data packet and its blocks' azimuths. The returns stay in the payload.
struct Packet {
  std::optional<uint32_t> number;  ///< counter of packets; nothing: 0, as where there is none
  int64_t time_ns = 0;      ///< device time of the first firing: since 1970, or since power-up
  float distance_unit = 0;  ///< m
  bool repeats_azimuths = false;  ///< the blocks of each pair, but not all blocks, share an azimuth
  bool stands = false;            ///< all blocks have one azimuth
  /// Azimuth of each block, 0.01°, 0 … 35999, clockwise, or `lidar::kNoAzimuth`.
  std::array<uint16_t, kBlocks> azimuth{};
};

/// True if a payload has the size and the mark of a data packet.
bool is_data_packet(std::span<const uint8_t> payload);

/// True if a payload begins as data packets of other RoboSense lidars do.
bool is_foreign_data_packet(std::span<const uint8_t> payload);

/// Parses a data packet: the manuals of RS-Helios-16P, 6.2 "MSOP", and of RS-Bpearl, 5.2 "MSOP".
tl::expected<Packet, PacketFault> parse_packet(std::span<const uint8_t> payload);

/// Name of a mode: "strongest return".
const char* name_of(ReturnMode mode);

/// Kinds of the returns of one firing, in their order on the wire.
std::array<ReturnKind, 2> return_kinds(ReturnMode mode);

}  // namespace infuse::robosense
