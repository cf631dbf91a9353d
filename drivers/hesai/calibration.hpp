#pragma once

#include <array>
#include <optional>
#include <string>

#include "drivers/hesai/model.hpp"

namespace infuse::hesai {

/// Direction of one beam, radians.
struct BeamAngles {
  double elevation = 0;       ///< above the horizontal
  double azimuth_offset = 0;  ///< added to the rotor's azimuth (clockwise)
};

/// Directions of all beams of a sensor by channel; entries from the model's `lasers` on are unused.
struct Calibration {
  std::array<BeamAngles, kMaxLasers> beams{};

  /// Returns what is wrong with the numbers for this model, or nothing: they must be finite and
  /// within the sensor's field of view, and no two beams may have the same direction.
  std::optional<std::string> invalid(const ModelInfo& info) const;

  /// Ring of each channel: 0 is the lowest beam.
  std::array<uint16_t, kMaxLasers> rings(const ModelInfo& info) const;
};

/// The model's angles as Hesai's files give them for an example unit. Those of another unit differ
/// by hundredths of a degree: its own file is better.
const Calibration& built_in_calibration(Model model);

}  // namespace infuse::hesai
