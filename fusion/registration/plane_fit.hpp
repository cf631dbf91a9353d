#pragma once

#include <array>

#include "fusion/features/lanes.hpp"

namespace infuse::registration {

using features::Doubles;

inline constexpr int kPlanes = 8;  ///< planes fitted side by side: lanes of `Doubles`

/// Upper triangles of eight symmetric positive semidefinite 3 × 3 matrices: xx, xy, xz, yy, yz, zz.
using Covariances = std::array<Doubles, 6>;

/// Planes of eight sets of points.
struct PlaneFits {
  std::array<Doubles, 3> normal;  ///< unit normals; (0, 0, 0): none
  Doubles smallest;               ///< variance across the plane
  Doubles others;                 ///< sum of the two variances along it
  Doubles product;                ///< product of the two variances along it
};

/// Fits planes to eight sets of points with these covariances. A set whose second variance is less
/// than `min_spread` of the first lies on a line and has no plane. Same bytes on every processor.
PlaneFits fit_planes(const Covariances& covariances, double min_spread);

}  // namespace infuse::registration
