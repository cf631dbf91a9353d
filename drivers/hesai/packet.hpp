#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>

#include "drivers/hesai/model.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::hesai {

/// Returns that a sensor sends; the values of the return mode byte.
enum class ReturnMode : uint8_t {
  kFirst = 0x33,
  kSecond = 0x34,
  kStrongest = 0x37,
  kLast = 0x38,
  kLastStrongest = 0x39,
  kFirstSecond = 0x3A,
  kFirstLast = 0x3B,
  kFirstStrongest = 0x3C,
  kFirstLastStrongest = 0x3D,
  kStrongestSecond = 0x3E,
};

/// Number of returns of one firing in a mode; 0 for a value that is no mode.
size_t number_of_returns(ReturnMode mode);

/// Name of the mode: "last and strongest".
const char* name_of(ReturnMode mode);

/// Reason why bytes are not a data packet of the model.
enum class PacketFault : uint8_t {
  kSize,        ///< shorter than the model's packets, or of an impossible length
  kHeader,      ///< marks, version, numbers of channels and blocks or unit of distance are not the
                ///< model's
  kReturnMode,  ///< no return mode of the model
  kAzimuth,     ///< most azimuths are above 360°, or differ between the blocks of one firing
  kTime,        ///< date or time of day that does not exist
};

/// Description of the fault for people.
const char* describe(PacketFault fault);

/// Headers of a packet's blocks and the packet's tail. The returns stay in the payload.
struct Packet {
  ReturnMode mode = ReturnMode::kStrongest;
  uint8_t returns = 1;    ///< of one firing: this many blocks in a row
  uint8_t sequences = 0;  ///< number of firings: blocks / returns
  uint8_t distance_unit_mm = 4;
  uint8_t factory = 0;       ///< the maker's mark, 0x42 or 0x43
  uint8_t loop = 0;          ///< QT128: firing sequence (0, 1) of the first firing
  uint16_t tail = 0;         ///< byte at which the tail begins
  uint16_t motor_speed = 0;  ///< rpm
  int64_t utc_ns = 0;        ///< device time of the packet: since 1970, as far as the device knows
  std::optional<uint32_t> number;  ///< counter of packets; firmware may lack it
  /// Azimuth of each firing, 0.01°, 0 … 35999, clockwise, or `lidar::kNoAzimuth`.
  std::array<uint16_t, kMaxBlocks> azimuth{};
};

/// Parses a payload without its azimuths and its time: how its returns are to be read.
tl::expected<Packet, PacketFault> parse_layout(const ModelInfo& info,
                                               std::span<const uint8_t> payload);

/// Parses a payload: the manuals of the models, "Point Cloud Data Packet".
tl::expected<Packet, PacketFault> parse_packet(const ModelInfo& info,
                                               std::span<const uint8_t> payload);

/// Kinds of the returns of one firing, in the order of its blocks. Equal returns become one of kind
/// `kBoth`.
std::array<ReturnKind, kMaxReturns> return_kinds(Model model, ReturnMode mode);

}  // namespace infuse::hesai
