#pragma once

#include <algorithm>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/registration/lengths.hpp"

namespace infuse::registration {

/// Reweighted least squares creep where points leave and enter the robust kernel: each step is a
/// little shorter than the one before. From their ratio follows how far all of them would lead
/// (Aitken's method along the step).
class Acceleration {
 public:
  /// By what to multiply a step.
  double factor(geometry::Vector6 step) {
    constexpr double kMaxFactor = 4;
    step.head<3>() *= kLever;
    const double square = last_.squaredNorm();
    double factor = 1;
    if (square > 0) {
      const double left = std::clamp(last_.dot(step) / square, -1.0, 1.0);
      // A step of `factor_` left this share of the distance; a plain one would leave `rate`.
      const double rate = 1 - (1 - left) / factor_;
      factor = std::clamp(1 / std::max(1 - rate, 1e-3), 1.0, kMaxFactor);
    }
    last_ = step;
    factor_ = factor;
    return factor;
  }

 private:
  geometry::Vector6 last_ = geometry::Vector6::Zero();
  double factor_ = 1;
};

}  // namespace infuse::registration
