#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "drivers/measurement/median.hpp"

namespace infuse::places {

/// Height of the ground, m, among points about an upright vehicle: a low quantile of the near ones.
inline double ground_height(const std::vector<Eigen::Vector3d>& points) {
  constexpr double kNear = 25;        // m (decision 17)
  constexpr double kQuantile = 0.05;  // below it are reflections and ditches (decision 17)
  std::vector<double> heights;
  for (const Eigen::Vector3d& p : points) {
    if (p.head<2>().norm() < kNear) heights.push_back(p.z());
  }
  if (heights.empty()) return 0;
  return nth_smallest(heights,
                      static_cast<size_t>(kQuantile * static_cast<double>(heights.size())));
}

}  // namespace infuse::places
