#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "drivers/measurement/rig.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/monitoring/axis.hpp"
#include "fusion/monitoring/scene_store.hpp"

namespace infuse::monitoring {

/// Settings of the re-estimation.
struct ReestimateOptions {
  int searches = 3;  ///< number of ascents: from the current calibration and from around it
  double screen_half_width = 0.02;  ///< rad, half width of the rotations screened around it
  double initial_translation_sigma = kKnockSigma;  ///< m, of the camera's displacement
  size_t points = 160'000;                         ///< maximum number, of all scenes together
  double max_split_half_distance =
      4;              ///< standard deviations by which the halves of the scenes may differ
  uint64_t seed = 1;  ///< of the restarts

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Result of a re-estimation from stored scenes.
struct Reestimate {
  Eigen::Isometry3d T_initial = Eigen::Isometry3d::Identity();  ///< calibration it started from
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< the result
  /// Covariance of a left perturbation (rx, ry, rz, tx, ty, tz), rad and m.
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
  double moved = 0;  ///< Mahalanobis distance from the current calibration
  double split_half_distance =
      0;  ///< Mahalanobis distance between the estimates of two halves of the scenes, over √6
  size_t scenes = 0;   ///< number of scenes used
  double support = 0;  ///< share of small wrong rotations that fit worse
  std::string reason;  ///< why the result cannot be used; empty if it can

  bool usable() const { return reason.empty(); }  ///< it may be used
};

/// Re-estimates T_camera_lidar from stored scenes of one camera: `calibration::calibrate` from the
/// current calibration, and from each half of the scenes alone as a check. Pure: runs on any
/// thread; takes the memory that accuracy.md states. Ends soon after `stop`, without a usable
/// result. Options must be valid.
Reestimate reestimate(std::span<const StoredScene* const> scenes, const CameraIntrinsics& camera,
                      const Eigen::Isometry3d& current, const ReestimateOptions& options,
                      const std::stop_token& stop = {});

}  // namespace infuse::monitoring
