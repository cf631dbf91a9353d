#include "drivers/robosense/model.hpp"

#include <array>

namespace infuse::robosense {
namespace {

constexpr std::array<ModelInfo, 2> kModels{
    {{Model::kHelios, "RS-Helios", 32}, {Model::kHelios16p, "RS-Helios-16P", 16}}};

}  // namespace

const ModelInfo& model_info(Model model) { return kModels[static_cast<size_t>(model)]; }

std::span<const ModelInfo> models() { return kModels; }

/// Byte 30 states the type in older firmware, and byte 31 in newer, whose byte 30 is 0; the next
/// byte states which of this type.
std::optional<Model> stated_model(std::span<const uint8_t> payload) {
  constexpr size_t kType = 30;
  constexpr uint8_t kHeliosType = 6, kOlder16pType = 7, k16pOfHelios = 3;
  const size_t at = payload[kType] == 0 ? kType + 1 : kType;
  if (payload[at] == kOlder16pType) return Model::kHelios16p;
  if (payload[at] != kHeliosType) return std::nullopt;
  return payload[at + 1] == k16pOfHelios ? Model::kHelios16p : Model::kHelios;
}

}  // namespace infuse::robosense
