#pragma once

#include <Eigen/Core>

#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Distances of the four points of a view from its board, m: the residuals of P(3.10).
using PointResiduals = Eigen::Vector4d;

/// Residuals and their derivative with respect to a left perturbation of T_refcam_lidar.
struct LinearisedView {
  PointResiduals residuals;
  Eigen::Matrix<double, 4, 6> jacobian;
};

/// Linearises a view at a given pose.
LinearisedView linearise_view(const TargetView& view, const ReturnsPlane& plane,
                              const Eigen::Isometry3d& T_refcam_lidar);

/// Covariance of the residuals, m²: of the ranges along their beams (`range_noise`, a quarter of
/// the returns per point) and of the pose of the board. Moving the board is equivalent to moving
/// its returns the other way, so both use the same derivative; these are the two parts of X in
/// P(3.12).
Eigen::Matrix4d residual_covariance(const TargetView& view, const ReturnsPlane& plane,
                                    const Eigen::Isometry3d& T_refcam_lidar, double range_noise);

}  // namespace infuse::target
