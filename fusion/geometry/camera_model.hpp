#pragma once

#include <Eigen/Core>
#include <optional>

#include "drivers/measurement/rig.hpp"

namespace infuse::geometry {

/// A pixel and how it moves.
struct ProjectionDerivatives {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;  ///< pixel per metre of the point, camera frame
  Eigen::Matrix<double, 2, 6> by_pose;   ///< per (rx, ry, rz, tx, ty, tz) of a left perturbation of
                                         ///< T_camera_lidar
};

/// A camera's intrinsics, with the directions for which its distortion can be inverted worked out.
/// Beyond them a polynomial distortion folds back and would put what is far outside the picture
/// into it; such points are not projected.
class CameraModel {
 public:
  /// `intrinsics.invalid()` must be empty.
  explicit CameraModel(const CameraIntrinsics& intrinsics);

  const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// Largest angle from the optical axis that is projected: as tan² for a pinhole, as radians for a
  /// fisheye.
  double limit() const { return limit_; }

  /// The pixel of a point in the camera frame (m); nothing where the model does not see it. The
  /// pixel may lie outside the picture. Brown–Conrady or Kannala–Brandt, as OpenCV documents them.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;

  /// `project` with its derivatives; `point` is T_camera_lidar times the lidar's point.
  std::optional<ProjectionDerivatives> project_with_derivatives(const Eigen::Vector3d& point) const;

  /// The direction (unit vector, camera frame) whose projection is the pixel, to 1e-9 pixels;
  /// nothing where there is none.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;

  /// The pixel lies in the picture: within half a pixel of a pixel's centre.
  bool in_image(const Eigen::Vector2d& pixel) const;

 private:
  std::optional<Eigen::Vector3d> unproject_pinhole(const Eigen::Vector2d& distorted) const;
  std::optional<Eigen::Vector3d> unproject_fisheye(const Eigen::Vector2d& distorted) const;

  CameraIntrinsics intrinsics_;
  double limit_ = 0;
};

}  // namespace infuse::geometry
