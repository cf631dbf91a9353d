#include "drivers/robosense/model.hpp"

#include <algorithm>
#include <array>

namespace infuse::robosense {
namespace {

// The beams of an RS-Bpearl next to the axis have any azimuth.
constexpr std::array<ModelInfo, 4> kModels{
    {{Model::kHelios, "RS-Helios", 32, kHeliosPeriodNs, 0.03498, 3'000},
     {Model::kHelios16p, "RS-Helios-16P", 16, kHeliosPeriodNs, 0.03498, 3'000},
     {Model::kBpearl, "RS-Bpearl", 32, 55'520, 0.01473, 18'000},
     {Model::kBpearlV4, "RS-Bpearl-V4", 32, kHeliosPeriodNs, 0.01619, 18'000}}};

}  // namespace

bool is_older_format(std::span<const uint8_t> payload) {
  constexpr std::array<uint8_t, 8> kMark{0x55, 0xAA, 0x05, 0x0A, 0x5A, 0xA5, 0x50, 0xA0};
  return payload.size() >= kMark.size() && std::equal(kMark.begin(), kMark.end(), payload.begin());
}

const ModelInfo& model_info(Model model) { return kModels[static_cast<size_t>(model)]; }

std::span<const ModelInfo> models() { return kModels; }

/// Byte 30 states the type in older firmware, and byte 31 in newer, whose byte 30 is 0; the next
/// byte states which of this type.
std::optional<Model> stated_model(std::span<const uint8_t> payload) {
  constexpr size_t kType = 30;
  constexpr uint8_t kBpearlType = 3, kHeliosType = 6, kOlder16pType = 7;
  constexpr uint8_t k16pOfHelios = 3, kV4OfBpearl = 4;
  if (is_older_format(payload)) {
    const bool newer = payload[kType + 1] == kBpearlType;
    if (newer && payload[kType + 2] == kV4OfBpearl) return Model::kBpearlV4;
    const bool bpearl = payload[kType] == kBpearlType || (newer && payload[kType] == 0);
    return bpearl ? std::optional(Model::kBpearl) : std::nullopt;
  }
  const size_t at = payload[kType] == 0 ? kType + 1 : kType;
  if (payload[at] == kOlder16pType) return Model::kHelios16p;
  if (payload[at] != kHeliosType) return std::nullopt;
  return payload[at + 1] == k16pOfHelios ? Model::kHelios16p : Model::kHelios;
}

}  // namespace infuse::robosense
