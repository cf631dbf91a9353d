#pragma once

#include <span>
#include <string>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {

/// A calibration from one drive.
struct DatedCalibration {
  double days = 0;  ///< date, days after any fixed one
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  /// What differs from drive to drive: positive definite, of a left perturbation, rad and m. What
  /// all drives of a vehicle share, as an error of the intrinsics, is not in it.
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
};

/// Poses combined with their covariances.
struct PooledPose {
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();  ///< if they are of one pose
  double chi_squared = 0;      ///< of the differences from the pooled pose
  int degrees_of_freedom = 0;  ///< 6 (n − 1)
  double p_value = 1;          ///< of so large differences between calibrations of one pose
  std::string reason;          ///< why there is no pose; empty if there is

  bool usable() const { return reason.empty(); }
};

/// Combines calibrations of one camera, each weighted by the inverse of its covariance: the pose of
/// maximum likelihood, by Gauss-Newton on SE(3), begun at `T_reference`. Barfoot, State Estimation
/// for Robotics, 7.3. Not usable without calibrations, or where it does not converge, as rotations
/// differ by about π.
PooledPose pool_calibrations(std::span<const DatedCalibration> calibrations,
                             const Eigen::Isometry3d& T_reference);

/// Poses that change by one motion: exp(wᵢ change) T_before, with a share wᵢ of 0 … 1 each.
struct ChangedPose {
  Eigen::Isometry3d T_before = Eigen::Isometry3d::Identity();
  geometry::Vector6 change = geometry::Vector6::Zero();  ///< left perturbation, rad and m
  /// Of an error of T_before, and of `change`.
  Eigen::Matrix<double, 12, 12> covariance = Eigen::Matrix<double, 12, 12>::Identity();
  double chi_squared = 0;      ///< of the differences from the changing pose
  int degrees_of_freedom = 0;  ///< 6 (n − 2)
  std::string reason;          ///< why there is none; empty if there is

  bool usable() const { return reason.empty(); }
};

/// As `pool_calibrations`, with `shares` of one change, as many as calibrations. Not usable if the
/// shares are all alike.
ChangedPose pool_changed(std::span<const DatedCalibration> calibrations,
                         std::span<const double> shares, const Eigen::Isometry3d& T_reference);

/// True if a covariance is finite, symmetric and positive definite.
bool is_covariance(const geometry::Matrix6& covariance);

}  // namespace infuse::calibration
