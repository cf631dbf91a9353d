#pragma once

#include <algorithm>
#include <vector>

#include "drivers/measurement/median.hpp"
#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

/// Median of χ² with the degrees of freedom of a pose.
template <int D>
inline constexpr double kChi2Median = D == 2 ? 2.366 : 5.348;

/// χ² that one pose in a thousand exceeds.
template <int D>
inline constexpr double kChi2Limit = D == 2 ? 16.27 : 22.46;

/// Factor by which covariances are too narrow, from the median of χ²; 1 without any.
template <int D>
double chi2_scale(std::vector<double> chi2) {
  if (chi2.empty()) return 1;
  return std::max(median(chi2) / kChi2Median<D>, 1e-9);
}

}  // namespace infuse::mapping
