#pragma once

#include <array>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::registration {

/// Normal equations of a left perturbation of the source's pose, about the origin of the pairs. The
/// directions of a factor and its isotropic rest are kept apart, since only planes inform.
struct PoseSystem {
  geometry::Matrix6 planes = geometry::Matrix6::Zero();     ///< Σ w Jᵀ (W − kIsotropic) J
  geometry::Matrix6 isotropic = geometry::Matrix6::Zero();  ///< Σ w Jᵀ kIsotropic J
  geometry::Vector6 gradient = geometry::Vector6::Zero();   ///< Σ w Jᵀ W r
  Eigen::Matrix3d arms = Eigen::Matrix3d::Zero();           ///< Σ w (pᵀp − p pᵀ), m²
  double cost = 0;                                          ///< Σ w rᵀ W r
  double weight = 0;                                        ///< Σ w
  Eigen::Vector3d mean{0, 0, 0};                            ///< of the points, weighted, m
  double radius = 0;  ///< m, root mean square distance of the points from the mean
};

/// Number of sums over pairs, by definition: upper triangle of `planes`, gradient, cost, weight,
/// first and second moments.
inline constexpr int kPoseSums = 21 + 6 + 2 + 3 + 6;

/// The system of those sums; `isotropic` is the factor's kIsotropic.
PoseSystem pose_system(const std::array<double, kPoseSums>& sums, double isotropic);

}  // namespace infuse::registration
