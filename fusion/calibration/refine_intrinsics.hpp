#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fusion/calibration/calibrate.hpp"

namespace infuse::calibration {

/// Intrinsics of one camera, estimated with the pose.
struct RefinedIntrinsics {
  CameraIntrinsics intrinsics;  ///< refined; as given where they are not refined
  /// Refined less given: the logarithm of the focal lengths, the principal point (u, v, px), k1.
  Eigen::Vector4d correction = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of `correction`
};

/// A calibration of cameras together with their intrinsics.
struct RefinedCalibration {
  /// With the refined intrinsics, whose uncertainty is part of `model_covariance`. Where they are
  /// not refined, with the given ones, and not usable: the reason says why.
  CalibrationResult result;
  bool refined = false;                    ///< of all cameras
  std::vector<RefinedIntrinsics> cameras;  ///< one per camera
};

/// Calibrates every camera by itself, corrects its focal length, principal point and k1 by their
/// joint estimate with its pose (`estimate_intrinsics`), and calibrates all together with these.
/// The poses of several cameras relative to each other are kept.
///
/// Intrinsics are not refined with fewer than 8 effective scenes, where an estimate does not
/// converge, or where a standard deviation exceeds half of what users ask of intrinsics: 0.25 % of
/// the focal length, 1 px of the principal point, 0.005 of k1. Nor if that is so for one camera
/// alone: its error would move the others' pose.
RefinedCalibration calibrate_with_intrinsics(std::span<const Scene> scenes,
                                             std::span<const RigCamera> cameras,
                                             const Eigen::Isometry3d& T_refcam_lidar_initial,
                                             const CalibrateOptions& options);

}  // namespace infuse::calibration
