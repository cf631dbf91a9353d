#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/sweep.hpp"

namespace infuse::calibration {

/// Settings of the surface normals.
struct NormalOptions {
  int neighbours = 100;  ///< returns that a plane is fitted to, I 4.3.1.3
  double max_neighbour_distance =
      2;  ///< m; where the last neighbour lies farther away, there is no normal
  size_t max_normals =
      20'000;  ///< returns of a sweep that get a normal, spread evenly over it; 0: all

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Surface normals, I 4.3.1.3: of the plane fitted by least squares to the nearest neighbours of a
/// return, unit length, lidar frame, turned towards the sensor. Three arrays, one entry a return;
/// `kNotCompared` where there is none.
std::array<std::vector<float>, 3> surface_normals(const Sweep& sweep, const NormalOptions& options);

/// Taylor and Nieto's normal feature, I 4.3.2: Δ_y² / √(Δ_x² + Δ_z²) between a return and the next
/// of one planar scan, whose y axis lies in it. A spinning lidar's planar scan is a firing's column
/// of rings, upright: y is the lidar's z, and x and z its x and y. m, never negative;
/// `kNotCompared` where the next ring has no return in the column.
std::vector<float> taylor_normal(const Sweep& sweep);

}  // namespace infuse::calibration
