#pragma once

#include <span>

#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {

/// How a sum over pixels changes with the pose: given ∂J/∂u and ∂J/∂v of every projected point,
///   Σ_i (∂J/∂u_i, ∂J/∂v_i) · ∂(u_i, v_i)/∂ξ
/// for a left perturbation ξ = (rx, ry, rz, tx, ty, tz) of T_camera_lidar: the adjoint of
/// `project_points`. Points that the model does not see must have zeros. The same bytes on every
/// processor.
Vector6 pose_gradient(const CameraModel& camera, const Eigen::Isometry3d& T_camera_lidar,
                      const PointsView& points, std::span<const float> by_u,
                      std::span<const float> by_v);

}  // namespace infuse::geometry
