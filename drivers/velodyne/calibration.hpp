#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {

/// How one beam leaves the sensor, and what its measurements must be corrected by. Angles in
/// radians, lengths in metres, in the vendor's axes (x right, y forward, z up; azimuth clockwise
/// from y). All but the two angles are zero on models whose units are alike.
struct BeamCorrection {
  double elevation = 0;          ///< above the horizontal; the vendor's vertCorrection
  double rotation = 0;           ///< subtracted from the encoder's azimuth; rotCorrection
  double distance = 0;           ///< added to a far distance; distCorrection
  double distance_x = 0;         ///< added at 2.40 m along x; distCorrectionX
  double distance_y = 0;         ///< added at 1.93 m along y; distCorrectionY
  double vertical_offset = 0;    ///< of the beam's origin, up
  double horizontal_offset = 0;  ///< of the beam's origin, across the beam
  double focal_distance = 0;     ///< where the receiver is in focus
  double focal_slope = 0;        ///< of the correction of reflectivity over focus
  double min_intensity = 0;      ///< reflectivity is clamped to this, 0 … 255
  double max_intensity = 255;
};

/// The corrections of all beams of a sensor; entries from the model's `lasers` on are unused.
struct Calibration {
  std::array<BeamCorrection, kMaxSlots> beams{};

  /// What is wrong with the numbers for this model, or nothing: finite, angles within the sensor's
  /// reach, corrections within metres.
  std::optional<std::string> invalid(const ModelInfo& info) const;

  /// Rings by laser: 0 is the lowest beam.
  std::array<uint16_t, kMaxSlots> rings(const ModelInfo& info) const;
};

/// The model's nominal beams; for an HDL-64E, whose units differ, those of an example unit (good to
/// look at, not to measure with).
const Calibration& built_in_calibration(Model model);

}  // namespace infuse::velodyne
