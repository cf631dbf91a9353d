#pragma once

#include <Eigen/Core>
#include <span>

#include "fusion/calibration/calibrate.hpp"

namespace infuse::calibration {

/// A calibration of a camera together with its intrinsics.
struct RefinedCalibration {
  /// With the refined intrinsics, whose uncertainty is part of `model_covariance`. Where they are
  /// not refined, with the given ones, and not usable: the reason says why.
  CalibrationResult result;
  CameraIntrinsics intrinsics;  ///< refined where `refined`, else as given
  bool refined = false;
  /// Refined less given: the logarithm of the focal lengths, the principal point (u, v, px), k1.
  Eigen::Vector4d correction = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of `correction`
};

/// Calibrates one camera, corrects its focal length, principal point and k1 by their joint estimate
/// with the pose (`estimate_intrinsics`), and calibrates again with these.
///
/// Intrinsics are not refined with fewer than 8 effective scenes, where the estimate does not
/// converge, or where a standard deviation exceeds half of what users ask of intrinsics: 0.25 % of
/// the focal length, 1 px of the principal point, 0.005 of k1.
RefinedCalibration calibrate_with_intrinsics(std::span<const Scene> scenes, const RigCamera& camera,
                                             const Eigen::Isometry3d& T_camera_lidar_initial,
                                             const CalibrateOptions& options);

}  // namespace infuse::calibration
