#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/measurement/sweep.hpp"
#include "drivers/ouster/metadata.hpp"

namespace infuse::ouster {

/// A sensor's directions and origins for the kernel: one direction for each column and beam, one
/// origin for each column, in the lidar frame (the sensor's: x forward, y left, z up; its origin is
/// the middle of the sensor's base).
///
/// The formula (Ouster's manual "Sensor Data"), with a range r, n = |beam origin|, encoder angle θ
/// = 2π (1 − column / columns), azimuth offset α, elevation φ: (r − n) (cos(θ − α) cos φ, sin(θ −
/// α) cos φ, sin φ) + (n_x cos θ, n_x sin θ, n_z), then T_sensor_lidar.
struct BeamTable {
  explicit BeamTable(const Metadata& metadata);

  uint16_t beams;     ///< a multiple of 8
  uint16_t rings;     ///< number of beams that the sensor has: 16 of 64 in firmware before 1.14
  float beam_radius;  ///< m: n of the formula
  /// Unit vectors: beam b of column c at c · beams + b.
  FieldVector<float> direction_x, direction_y, direction_z;
  /// Of the column's beams, m.
  std::vector<float> origin_x, origin_y, origin_z;
  /// Number of each beam by elevation, counted from below.
  alignas(32) std::array<int32_t, kMaxBeams> ring{};
};

}  // namespace infuse::ouster
