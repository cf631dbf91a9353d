#pragma once

#include <Eigen/Core>

#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Distances of a view's four points from its board, m: the residuals of P(3.10).
using PointResiduals = Eigen::Vector4d;

/// `PointResiduals` and their derivative by a left perturbation of T_refcam_lidar.
struct LinearisedView {
  PointResiduals residuals;
  Eigen::Matrix<double, 4, 6> jacobian;
};

/// Of a view under a hypothesis.
LinearisedView linearise_view(const TargetView& view, const ReturnsPlane& plane,
                              const Eigen::Isometry3d& T_refcam_lidar);

/// Covariance of the residuals, m²: of the ranges along their beams (`range_noise`, a quarter of
/// the returns to a point), and of the board's pose. A motion of the board is a motion of its
/// returns the other way, so the same derivative carries both; these are the two parts of X in
/// P(3.12).
Eigen::Matrix4d residual_covariance(const TargetView& view, const ReturnsPlane& plane,
                                    const Eigen::Isometry3d& T_refcam_lidar, double range_noise);

}  // namespace infuse::target
