#pragma once

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::target {

/// Pose parametrisation for Ceres: T = exp(ξ) T_initial, initially ξ = 0.
struct PoseParameter {
  Eigen::Isometry3d T_initial;

  Eigen::Isometry3d at(const double* xi) const {
    return geometry::exp(Eigen::Map<const geometry::Vector6>(xi)) * T_initial;
  }

  /// Converts a derivative by a left perturbation of `at(xi)` to one by ξ.
  template <class Rows>
  static auto jacobian_by_xi(const Rows& by_perturbation, const double* xi) {
    return (by_perturbation * geometry::left_jacobian(Eigen::Map<const geometry::Vector6>(xi)))
        .eval();
  }
};

}  // namespace infuse::target
