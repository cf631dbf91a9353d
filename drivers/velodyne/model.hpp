#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/measurement/stamp.hpp"

namespace infuse::velodyne {

/// The sensors that this driver knows.
enum class Model : uint8_t {
  kHdl32e,
  kVlp16,
  kPuckHiRes,
  kVlp32c,
  kHdl64eS2,
  kHdl64eS3,
  kVls128,
};

/// Which echoes a sensor sends; the values of the return mode byte.
enum class ReturnMode : uint8_t { kStrongest = 0x37, kLast = 0x38, kDual = 0x39 };

/// Returns that one block of a packet holds.
inline constexpr size_t kSlotsPerBlock = 32;
/// Slots of the largest firing sequence (VLS-128).
inline constexpr size_t kMaxSlots = 128;

/// What distinguishes the models on the wire and in time. A *firing sequence* is what shares one
/// azimuth in a packet: a block, two blocks (HDL-64E) or four (VLS-128). It holds `slots()` slots
/// in order of the wire; a VLP-16's sequence holds two firings of its 16 lasers, one after the
/// other.
struct ModelInfo {
  Model model;
  const char* name;           ///< "HDL-32E", as drive.toml and people write it
  uint16_t lasers;            ///< beams
  uint16_t firings;           ///< firings of all lasers in a sequence: 2 for 16 beams, else 1
  uint16_t banks;             ///< blocks in a sequence, of one return kind
  uint16_t distance_unit_mm;  ///< of a packet's distance
  uint8_t product_id;         ///< byte 1205; 0 where the model sends something else there
  Duration cycle;             ///< from one firing to the next of the same laser, nominal
  bool calibrated_per_unit;   ///< each unit has its own full calibration (HDL-64E)
  bool has_dual_return;       ///< can send two returns

  /// Slots of a firing sequence.
  constexpr size_t slots() const { return banks * kSlotsPerBlock; }
  /// Firing sequences in a packet.
  size_t sequences_per_packet(bool dual_return) const;
};

/// The table's row of a model.
const ModelInfo& model_info(Model model);

/// All models, in the order of the enumeration.
std::span<const ModelInfo> models();

/// By name: letters and digits count, case and "-", "_", " " do not ("vlp16", "VLP-16").
std::optional<Model> find_model(std::string_view name);

/// From the start of a firing sequence to the next one's, given the firing cycle.
constexpr Duration sequence_period(const ModelInfo& info, Duration cycle) {
  return cycle * info.firings;
}

/// From one packet's counter to the next one's, given the firing cycle.
Duration packet_period(const ModelInfo& info, Duration cycle, bool dual_return);

/// When each slot of a firing sequence fires, ns after the sequence's start, for a given firing
/// cycle (the manuals' timing tables; they scale with the cycle only where the firmware decides
/// it, on the VLS-128). Entries from `slots()` on are 0.
std::array<int32_t, kMaxSlots> firing_times(const ModelInfo& info, Duration cycle);

}  // namespace infuse::velodyne
