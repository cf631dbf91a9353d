#pragma once

#include <numeric>
#include <vector>

#include "fusion/dependence/joint_histogram.hpp"

namespace infuse::dependence {

/// Makes a histogram from counts, `bins_x` rows of `bins_y`.
inline JointHistogram joint_table(const std::vector<double>& mass, int bins_x, int bins_y) {
  JointHistogram histogram{.bins_x = bins_x, .bins_y = bins_y, .mass = mass};
  histogram.samples = std::accumulate(mass.begin(), mass.end(), 0.0);
  update_total(histogram);
  return histogram;
}

}  // namespace infuse::dependence
