#pragma once

#include <Eigen/Core>
#include <optional>

#include "drivers/measurement/rig.hpp"

namespace infuse::geometry {

/// Pixel of a point and its derivatives.
struct ProjectionDerivatives {
  Eigen::Vector2d pixel;                 ///< u, v
  Eigen::Matrix<double, 2, 3> by_point;  ///< pixel per metre of the point, camera frame
  Eigen::Matrix<double, 2, 6>
      by_pose;  ///< per (rx, ry, rz, tx, ty, tz) of a left perturbation of T_camera_lidar
};

/// Intrinsics of a camera with the range of directions in which its distortion is invertible.
/// Beyond that range a polynomial distortion folds back and would map points far outside the image
/// into it; such points are not projected.
class CameraModel {
 public:
  /// `intrinsics.invalid()` must be empty.
  explicit CameraModel(const CameraIntrinsics& intrinsics);

  /// The intrinsics of the model.
  const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// Largest projected angle from the optical axis: tan² of it for a pinhole, radians for a
  /// fisheye.
  double limit() const { return limit_; }

  /// Returns the pixel of a point in the camera frame (m), or nullopt where the model is not
  /// defined. The pixel may lie outside the image. Brown–Conrady or Kannala–Brandt distortion as
  /// documented by OpenCV.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;

  /// Returns `project` with its derivatives; `point` is T_camera_lidar times the point in the lidar
  /// frame.
  std::optional<ProjectionDerivatives> project_with_derivatives(const Eigen::Vector3d& point) const;

  /// Returns the direction (unit vector, camera frame) that projects to the pixel, to 1e-9 pixels;
  /// nullopt if there is none.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;

  /// True if the pixel lies in the image: at most half a pixel from the centre of some pixel.
  bool in_image(const Eigen::Vector2d& pixel) const;

 private:
  std::optional<Eigen::Vector3d> unproject_pinhole(const Eigen::Vector2d& distorted) const;
  std::optional<Eigen::Vector3d> unproject_fisheye(const Eigen::Vector2d& distorted) const;

  CameraIntrinsics intrinsics_;
  double limit_ = 0;
};

}  // namespace infuse::geometry
