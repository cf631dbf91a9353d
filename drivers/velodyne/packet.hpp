#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <tl/expected.hpp>

#include "drivers/lidar/arrival_order.hpp"
#include "drivers/lidar/azimuth.hpp"
#include "drivers/lidar/little_endian.hpp"
#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {

/// Bytes of a data packet's payload.
inline constexpr size_t kPacketSize = 1206;
/// Number of blocks in a data packet.
inline constexpr size_t kBlocks = 12;
/// Bytes of a block: flag, azimuth, 32 returns of 3 bytes.
inline constexpr size_t kBlockSize = 100;
using lidar::kCentidegree;
using lidar::kCentidegreesPerTurn;
using lidar::kNoAzimuth;
using lidar::read_u16;
using lidar::read_u32;

/// Microseconds in an hour, after which the counter wraps.
inline constexpr int64_t kHourUs = 3'600'000'000;

/// Places of the counter and of the last two bytes in a data packet's payload.
inline constexpr size_t kCounterOffset = 1200;
inline constexpr size_t kReturnModeOffset = 1204;
inline constexpr size_t kProductIdOffset = 1205;

/// The payload of a data packet.
using PacketBytes = std::span<const uint8_t, kPacketSize>;

/// The bytes of a block of a data packet.
inline const uint8_t* block_at(std::span<const uint8_t> payload, size_t block) {
  return payload.data() + block * kBlockSize;
}

/// Reason why bytes are not a data packet of the model.
enum class PacketFault : uint8_t {
  kSize,        ///< not 1206 bytes
  kFlag,        ///< a block does not begin with a flag of the model
  kAzimuth,     ///< most azimuths are above 360°
  kDualPair,    ///< dual return, but the blocks of a pair differ in azimuth
  kReturnMode,  ///< dual return from a model that has none
};

/// Description of the fault for people.
const char* describe(PacketFault fault);

/// Headers of a packet's blocks and the packet's end. The returns stay in the payload.
struct Packet {
  uint32_t counter_us = 0;  ///< device time of the first firing: µs since the top of the hour, or
                            ///< since power-up; may slightly exceed an hour
  ReturnMode mode = ReturnMode::kStrongest;
  uint8_t product_id = 0;   ///< byte 1205; on an HDL-64E the value of `status_type`
  uint8_t status_type = 0;  ///< byte 1204; on an HDL-64E the meaning of the last byte
  uint8_t sequences = 0;    ///< number of firing sequences
  /// Azimuth of each sequence, 0.01°, 0 … 35999, clockwise, or `kNoAzimuth`.
  std::array<uint16_t, kBlocks> azimuth{};

  bool dual() const { return mode == ReturnMode::kDual; }
};

/// Position of a firing sequence's blocks in a packet: bank `b` of echo `e` of sequence `i` is
/// block i·sequence + b·bank + e·echo.
struct BlockLayout {
  uint8_t sequence, bank, echo;

  size_t block(size_t i, size_t b, size_t e) const { return i * sequence + b * bank + e * echo; }
};

/// The block layout of a model's packets.
BlockLayout block_layout(const ModelInfo& info, bool dual_return);

/// Parses the headers of a payload of this model. An HDL-64E has no flag for two returns: they are
/// recognised by repeated azimuths.
tl::expected<Packet, PacketFault> parse_packet(const ModelInfo& info,
                                               std::span<const uint8_t> payload);

/// Difference of two counters, µs, across the top of the hour: in ±30 minutes.
constexpr int64_t counter_difference_us(uint32_t later, uint32_t earlier) {
  using std::chrono::microseconds;
  return lidar::counter_difference(microseconds(later), microseconds(earlier),
                                   microseconds(kHourUs))
             .count() /
         1000;
}

}  // namespace infuse::velodyne
