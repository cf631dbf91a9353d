#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/measurement/stamp.hpp"

namespace infuse::hesai {

/// Supported sensor models.
enum class Model : uint8_t {
  kPandar40p,
  kPandar64,
  kQt64,
  kQt128,
  kXt16,
  kXt32,
  kXt32m,
};

/// Number of channels of the largest model (QT128).
inline constexpr size_t kMaxLasers = 128;
/// Number of blocks of the largest packet (Pandar40P).
inline constexpr size_t kMaxBlocks = 10;
/// Number of returns of one firing that a packet can hold at most (XT32M).
inline constexpr size_t kMaxReturns = 3;

/// Position of the fields of a packet's tail, bytes from its start.
struct TailLayout {
  uint8_t return_mode, motor_speed, date, microseconds, factory;
  uint8_t size;
};

/// Packet layout of a model. A packet is a header, `blocks` blocks (an azimuth and one unit for
/// each channel: distance, reflectivity, on most models a fourth byte that is not used), a tail, on
/// most firmware a counter of packets.
struct ModelInfo {
  Model model;
  const char* name;      ///< "XT32", as in drive.toml and in text
  uint16_t lasers;       ///< number of beams
  uint8_t blocks;        ///< in a packet
  uint8_t protocol;      ///< major version in the 12-byte header; 0: another header, or none
  uint8_t header_size;   ///< bytes: 0 (Pandar40P), 8 (Pandar64) or 12
  uint8_t block_prefix;  ///< bytes before a block's units; the last two are the azimuth
  uint8_t unit_size;     ///< bytes of a unit: 3 or 4
  TailLayout tail;
  Duration period;      ///< from one firing of a channel to the next
  uint8_t max_returns;  ///< of one firing

  /// Bytes from one block to the next.
  constexpr size_t block_size() const { return block_prefix + size_t{unit_size} * lasers; }
  /// Bytes up to the end of the last block.
  constexpr size_t body_end() const { return header_size + blocks * block_size(); }
};

/// Table entry of a model.
const ModelInfo& model_info(Model model);

/// All models, in the order of the enumeration.
std::span<const ModelInfo> models();

/// True if a payload has the marks, version and numbers of channels and blocks of a model's data
/// packets, and is long enough for its blocks and tail.
bool has_header(const ModelInfo& info, std::span<const uint8_t> payload);

/// Recognises the model of a data packet by its marks, its header's version and numbers of channels
/// and blocks, and its size; nothing if it is no data packet of a supported model.
std::optional<Model> recognise(std::span<const uint8_t> payload);

/// True if a payload begins as those of Hesai's rotating lidars do (EE FF and a plausible header,
/// or FF EE at the start of ten blocks of 40 channels), of a supported model or not.
bool looks_like_hesai(std::span<const uint8_t> payload);

}  // namespace infuse::hesai
