#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "fusion/dependence/histogram_measures.hpp"
#include "tests/fusion/dependence/joint_table.hpp"

namespace infuse::dependence {

/// Cubic B-spline β³ by its definition.
inline double cubic_spline(double t) {
  t = std::abs(t);
  if (t < 1) return 2.0 / 3 - t * t + t * t * t / 2;
  return t < 2 ? (2 - t) * (2 - t) * (2 - t) / 6 : 0;
}

/// Position of `value` on the axis, in bins: the ends are one bin inside the table.
inline double axis_position(double value, const Axis& axis) {
  const double t = (value - axis.low) / (axis.high - axis.low);
  return 1 + std::min(1.0, std::max(0.0, t)) * (axis.bins - 3);
}

/// B-spline joint histogram by its definition: every sample against every bin, in double.
template <class Values>
JointHistogram spline_oracle(const Values& x, const Values& y, const JointHistogramOptions& options,
                             const std::vector<float>& weights = {}) {
  std::vector<double> mass(static_cast<size_t>(options.x.bins * options.y.bins));
  for (size_t i = 0; i < x.size(); ++i) {
    for (int k = 0; k < options.x.bins; ++k) {
      for (int l = 0; l < options.y.bins; ++l) {
        mass[static_cast<size_t>(k * options.y.bins + l)] +=
            (weights.empty() ? 1.0 : double(weights[i])) *
            cubic_spline(axis_position(double(x[i]), options.x) - k) *
            cubic_spline(axis_position(double(y[i]), options.y) - l);
      }
    }
  }
  return joint_table(mass, options.x.bins, options.y.bins);
}

}  // namespace infuse::dependence
