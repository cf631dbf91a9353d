#pragma once

#include <span>

#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {

/// Gradient of a sum over pixels with respect to the pose, the adjoint of `project_points`:
///   Σ_i (∂J/∂u_i, ∂J/∂v_i) · ∂(u_i, v_i)/∂ξ
/// for a left perturbation ξ = (rx, ry, rz, tx, ty, tz) of T_camera_lidar. The derivatives of
/// points outside the model's range must be zero. Same bytes on every processor.
Vector6 pose_gradient(const CameraModel& camera, const Eigen::Isometry3d& T_camera_lidar,
                      const PointsView& points, std::span<const float> by_u,
                      std::span<const float> by_v);

}  // namespace infuse::geometry
