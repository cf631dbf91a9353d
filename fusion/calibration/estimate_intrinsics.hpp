#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <stop_token>

#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/model_check.hpp"
#include "fusion/calibration/visible_points.hpp"

namespace infuse::calibration {

/// Estimate of one camera's intrinsics.
struct IntrinsicsEstimate {
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();  ///< estimated with them
  /// Estimated minus given: the logarithm of the focal lengths, the principal point (u, v, px), the
  /// first radial distortion coefficient.
  Eigen::Vector4d correction = Eigen::Vector4d::Zero();
  /// The last level ended at a maximum, at most 10 % of the focal length, 7.5 % of it in the
  /// principal point and 0.15 in k1 from the given intrinsics.
  bool converged = true;
  int scenes = 0;           ///< number of the camera's scenes that were compared
  int improved_scenes = 0;  ///< number of these that fit better than with the given intrinsics
  /// Mean gain of a scene divided by its standard error (Student's t).
  double significance = 0;
};

/// Maximises the terms over the pose and one camera's intrinsics together, coarse to fine, from the
/// pose estimated with the given intrinsics, and compares the fit of every scene alone, on the
/// points in view with the given intrinsics. Detects gross errors, for which the slope at the
/// result
/// (`check_model`) is not valid. Returns nothing if fewer than 8 of the camera's scenes have enough
/// points in view, or if `stop` was requested.
std::optional<IntrinsicsEstimate> estimate_intrinsics(
    std::span<const Scene> scenes, std::span<const RigCamera> cameras, size_t camera,
    std::span<const TermOptions> terms, ImagePyramid& images, const VisibilityOptions& visibility,
    const Eigen::Isometry3d& T_refcam_lidar, const std::stop_token& stop);

/// Returns the intrinsic with the largest error, as serious, if the error exceeds what any
/// calibration of a camera leaves (2 % of the focal length, 1.5 % of it in the principal point,
/// 0.04 in k1) and is significant (4 standard errors); or the intrinsics as a whole, without a
/// value, if the estimate did not converge within its bounds. Otherwise nothing. `cameras` have the
/// given intrinsics.
std::optional<ModelMismatch> detect_gross_mismatch(const IntrinsicsEstimate& estimate,
                                                   std::span<const RigCamera> cameras,
                                                   size_t camera);

}  // namespace infuse::calibration
