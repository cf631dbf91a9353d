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
  kBpearl,     ///< RS-Bpearl, versions 2 and 3: 32 beams
  kBpearlV4,   ///< RS-Bpearl, version 4: 32 beams
};

/// Number of channels of a block, and of the beams of the largest model.
inline constexpr size_t kChannels = 32;

/// Table entry of a model.
struct ModelInfo {
  Model model;
  const char* name;  ///< "RS-Helios", as in drive.toml and in text
  uint16_t lasers;   ///< number of beams: 32, or 16, which fire twice for one block of one return
  /// Time from one firing of all channels to the next, ns.
  int32_t period_ns;
  double origin_m;         ///< distance of the beams' origins from the axis of rotation, m
  int max_azimuth_offset;  ///< of a beam from the rotor, 0.01°
};

/// Time from one firing of all channels of an RS-Helios to the next, ns: that of a block.
inline constexpr int32_t kHeliosPeriodNs = 55'556;

/// Table entry of a model.
const ModelInfo& model_info(Model model);

/// All models, in the order of the enumeration.
std::span<const ModelInfo> models();

/// True if a payload begins as data packets of RS-LiDAR-16, RS-LiDAR-32, RS-Bpearl and RS-Ruby do.
bool is_older_format(std::span<const uint8_t> payload);

/// The model that a data packet states; nothing if it is another one's. The payload must be long
/// enough for a header.
std::optional<Model> stated_model(std::span<const uint8_t> payload);

}  // namespace infuse::robosense
