#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <stop_token>

#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/model_check.hpp"
#include "fusion/calibration/visible_points.hpp"

namespace infuse::calibration {

/// What one camera's intrinsics would rather be.
struct IntrinsicsEstimate {
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();  ///< that goes with them
  /// Found less given: the logarithm of the focal lengths, the principal point (u, v, px), the
  /// first radial distortion coefficient.
  Eigen::Vector4d correction = Eigen::Vector4d::Zero();
  int scenes = 0;           ///< of that camera that were asked
  int improved_scenes = 0;  ///< of these, such as fit better than with the given intrinsics
  /// Mean gain of a scene against its standard error (Student's t).
  double significance = 0;
};

/// Maximises the terms by the pose and by one camera's intrinsics together, from the pose that was
/// found with the given ones, coarse to fine, and asks every scene by itself which fits better:
/// those points it compares on are such as are in view as given. Finds what is far off, where the
/// slope next to the result (`check_model`) says nothing any more. Nothing where fewer than 8 of
/// the camera's scenes have enough points in view, or where `stop` was requested.
std::optional<IntrinsicsEstimate> estimate_intrinsics(
    std::span<const Scene> scenes, std::span<const RigCamera> cameras, size_t camera,
    std::span<const TermOptions> terms, ImagePyramid& images, const VisibilityOptions& visibility,
    const Eigen::Isometry3d& T_head_lidar, const std::stop_token& stop);

/// The intrinsic that is farthest off, where that is too far for any calibration of the camera (2 %
/// of the focal length, 1.5 % of it in the principal point, 0.04 in k1) and not by chance (4
/// standard errors): serious. Otherwise nothing. `cameras` as given.
std::optional<ModelMismatch> detect_gross_mismatch(const IntrinsicsEstimate& estimate,
                                                   std::span<const RigCamera> cameras,
                                                   size_t camera);

}  // namespace infuse::calibration
