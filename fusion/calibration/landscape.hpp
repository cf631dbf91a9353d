#pragma once

#include <array>
#include <utility>
#include <vector>

#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// The measure around a pose, for a person to look at (P fig. 3.15). Axes are 0 … 5: about and
/// along the head's x, y, z.
struct Landscape {
  static constexpr int kSamplesPerAxis =
      41;                              ///< values along an axis, the pose itself in the middle
  static constexpr int kMapSize = 15;  ///< values along each side of a map

  double rotation = 0;     ///< rad, how far the axes reach to either side
  double translation = 0;  ///< m

  std::array<std::array<double, kSamplesPerAxis>, 6> axis_profiles{};

  /// A map over two axes: value [row · kAcross + column], rows along `second`.
  struct Map {
    int first = 0, second = 0;
    std::array<double, size_t{kMapSize} * kMapSize> values{};
  };
  std::vector<Map> maps;  ///< all 15 pairs
};

/// Asks `fine` along the axes and `few`, of fewer points, over the pairs of them: 246 and 3375
/// evaluations.
Landscape sample_landscape(Objective& fine, Objective& coarse,
                           const Eigen::Isometry3d& T_head_lidar, double rotation,
                           double translation);

}  // namespace infuse::calibration
