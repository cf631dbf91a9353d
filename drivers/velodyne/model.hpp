#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/measurement/stamp.hpp"

namespace infuse::velodyne {

/// Supported sensor models.
enum class Model : uint8_t {
  kHdl32e,
  kVlp16,
  kPuckHiRes,
  kVlp32c,
  kHdl64eS2,
  kHdl64eS3,
  kVls128,
};

/// Echoes that a sensor sends; the values of the return mode byte.
enum class ReturnMode : uint8_t { kStrongest = 0x37, kLast = 0x38, kDual = 0x39 };

/// Number of returns in one block of a packet.
inline constexpr size_t kSlotsPerBlock = 32;
/// Number of slots of the largest firing sequence (VLS-128).
inline constexpr size_t kMaxSlots = 128;

/// Packet layout and timing of a model. A *firing sequence* is the data that shares one azimuth in
/// a packet: a block, two blocks (HDL-64E) or four (VLS-128). It holds `slots()` slots in wire
/// order; a VLP-16's sequence holds two firings of its 16 lasers, one after the other.
struct ModelInfo {
  Model model;
  const char* name;           ///< "HDL-32E", as in drive.toml and in text
  uint16_t lasers;            ///< number of beams
  uint16_t firings;           ///< firings of all lasers in a sequence: 2 for 16 beams, else 1
  uint16_t banks;             ///< blocks of one return kind in a sequence
  uint16_t distance_unit_mm;  ///< unit of a packet's distance
  uint8_t product_id;         ///< byte 1205; 0 if the model sends something else there
  Duration cycle;             ///< from one firing of a laser to the next, nominal
  bool calibrated_per_unit;   ///< each unit has its own full calibration (HDL-64E)
  bool has_dual_return;       ///< can send two returns

  /// Number of slots of a firing sequence.
  constexpr size_t slots() const { return banks * kSlotsPerBlock; }
  /// Number of firing sequences in a packet.
  size_t sequences_per_packet(bool dual_return) const;
};

/// Table entry of a model.
const ModelInfo& model_info(Model model);

/// All models, in the order of the enumeration.
std::span<const ModelInfo> models();

/// Time from the start of a firing sequence to the next one's, for a firing cycle.
constexpr Duration sequence_period(const ModelInfo& info, Duration cycle) {
  return cycle * info.firings;
}

/// Time from one packet's counter to the next one's, for a firing cycle.
Duration packet_period(const ModelInfo& info, Duration cycle, bool dual_return);

/// Firing time of each slot of a firing sequence, ns after the sequence's start, for a firing cycle
/// (the manuals' timing tables; they scale with the cycle only if the firmware determines it, on
/// the VLS-128). Entries from `slots()` on are 0.
std::array<int32_t, kMaxSlots> firing_times(const ModelInfo& info, Duration cycle);

}  // namespace infuse::velodyne
