#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {

/// Direction and corrections of one beam. Angles in radians, lengths in metres, in the vendor's
/// axes (x right, y forward, z up; azimuth clockwise from y). All but the two angles are zero for
/// models whose units are identical.
struct BeamCorrection {
  double elevation = 0;          ///< above the horizontal; the vendor's vertCorrection
  double rotation = 0;           ///< subtracted from the encoder's azimuth; rotCorrection
  double distance = 0;           ///< added to a far distance; distCorrection
  double distance_x = 0;         ///< added at 2.40 m along x; distCorrectionX
  double distance_y = 0;         ///< added at 1.93 m along y; distCorrectionY
  double vertical_offset = 0;    ///< of the beam's origin, upwards
  double horizontal_offset = 0;  ///< of the beam's origin, across the beam
  double focal_distance = 0;     ///< distance at which the receiver is in focus
  double focal_slope = 0;        ///< slope of the reflectivity correction over focus
  double min_intensity = 0;      ///< minimum reflectivity after correction, 0 … 255
  double max_intensity = 255;
};

/// Corrections of all beams of a sensor; entries from the model's `lasers` on are unused.
struct Calibration {
  std::array<BeamCorrection, kMaxSlots> beams{};

  /// Returns what is wrong with the numbers for this model, or nothing: they must be finite, angles
  /// within the sensor's field of view, corrections within metres.
  std::optional<std::string> invalid(const ModelInfo& info) const;

  /// Ring of each laser: 0 is the lowest beam.
  std::array<uint16_t, kMaxSlots> rings(const ModelInfo& info) const;
};

/// The model's nominal beams; for an HDL-64E, whose units differ, those of an example unit (for
/// viewing, not for measuring).
const Calibration& built_in_calibration(Model model);

}  // namespace infuse::velodyne
