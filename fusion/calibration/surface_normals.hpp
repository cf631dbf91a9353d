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

}  // namespace infuse::calibration
