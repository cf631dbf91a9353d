#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace infuse::robosense {

/// Supported sensor models.
enum class Model : uint8_t {
  kHelios,     ///< RS-Helios-5515, -1615, -1610: 32 beams
  kHelios16p,  ///< RS-Helios-16P: 16 beams
};

/// Number of channels of a block, and of the beams of the largest model.
inline constexpr size_t kChannels = 32;

/// Table entry of a model.
struct ModelInfo {
  Model model;
  const char* name;  ///< "RS-Helios", as in drive.toml and in text
  uint16_t lasers;   ///< number of beams: 32, or 16, which fire twice for one block of one return
};

/// Table entry of a model.
const ModelInfo& model_info(Model model);

/// All models, in the order of the enumeration.
std::span<const ModelInfo> models();

/// The model that a data packet states; nothing if it is another one's. The payload must be long
/// enough for a header.
std::optional<Model> stated_model(std::span<const uint8_t> payload);

}  // namespace infuse::robosense
