#pragma once

#include <array>
#include <optional>
#include <string>

#include "drivers/robosense/model.hpp"

namespace infuse::robosense {

/// Direction of one beam, 0.01°, as sensors state it.
struct BeamAngles {
  int elevation = 0;       ///< above the horizontal
  int azimuth_offset = 0;  ///< added to the rotor's azimuth (clockwise)

  bool operator==(const BeamAngles&) const = default;
};

/// Directions of all beams of a sensor by channel; entries from the model's `lasers` on are unused.
struct Calibration {
  std::array<BeamAngles, kChannels> beams{};
  bool anticlockwise = false;  ///< the rotor turns so, and its azimuth grows; RS-Bpearl only

  bool operator==(const Calibration&) const = default;

  /// Returns what is wrong with the numbers for this model, or nothing: they must be within the
  /// sensor's field of view, and no two beams may have the same direction.
  std::optional<std::string> invalid(const ModelInfo& info) const;

  /// Ring of each channel: 0 is the lowest beam.
  std::array<uint16_t, kChannels> rings(const ModelInfo& info) const;
};

/// The model's nominal angles; of an RS-Helios those of an RS-Helios-5515.
const Calibration& built_in_calibration(Model model);

}  // namespace infuse::robosense
