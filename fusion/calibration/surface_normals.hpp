#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/sweep.hpp"

namespace infuse::calibration {

/// Settings of the surface normals.
struct NormalOptions {
  int neighbours = 100;  ///< number of returns that a plane is fitted to, I 4.3.1.3
  double max_neighbour_distance =
      2;  ///< m; returns whose last neighbour is farther away have no normal
  size_t max_normals =
      20'000;  ///< maximum number of normals of a sweep, spread evenly over it; 0: all

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Computes surface normals, I 4.3.1.3: of the plane fitted by least squares to the nearest
/// neighbours of a return, unit length, lidar frame, facing the sensor. Three arrays, one entry per
/// return; `kNotCompared` where there is no normal.
std::array<std::vector<float>, 3> surface_normals(const Sweep& sweep, const NormalOptions& options);

}  // namespace infuse::calibration
