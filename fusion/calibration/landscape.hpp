#pragma once

#include <array>
#include <utility>
#include <vector>

#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// Objective around a pose, for plots (P fig. 3.15). Axes are 0 … 5: rotation about and translation
/// along x, y, z of the reference camera.
struct Landscape {
  /// Number of values along an axis, the pose itself in the middle: for plots, bounds time.
  static constexpr int kSamplesPerAxis = 41;
  static constexpr int kMapSize = 15;  ///< values along each side of a map; bounds time

  double rotation = 0;     ///< rad, half width of the axes
  double translation = 0;  ///< m, half width of the axes

  std::array<std::array<double, kSamplesPerAxis>, 6> axis_profiles{};

  /// Map over two axes: value [row · kMapSize + column], rows along `second`.
  struct Map {
    int first = 0, second = 0;
    std::array<double, size_t{kMapSize} * kMapSize> values{};
  };
  std::vector<Map> maps;  ///< all 15 pairs
};

/// Evaluates `fine` along the axes and `coarse`, of fewer points, over the pairs of axes: 246 and
/// 3375 evaluations.
Landscape sample_landscape(Objective& fine, Objective& coarse,
                           const Eigen::Isometry3d& T_refcam_lidar, double rotation,
                           double translation);

}  // namespace infuse::calibration
