#pragma once

#include <array>
#include <optional>
#include <string>

#include "fusion/monitoring/calibration_monitor.hpp"

namespace infuse::monitoring {

/// Settings of a profile.
struct ProfileOptions {
  double rotation = 0.026;    ///< rad; half width along the rotations
  double translation = 0.25;  ///< m; half width along the translations
  MonitorOptions evaluation;  ///< image, returns and weights, as the monitoring has them

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Dependence of an image and a sweep around a pose: along each axis of a left perturbation of
/// T_camera_lidar (rx, ry, rz, tx, ty, tz), the other five being zero.
struct DependenceProfile {
  static constexpr size_t kAxes = 6;      ///< of a pose, by definition
  static constexpr size_t kSamples = 25;  ///< along an axis, the pose in the middle: bounds time
  std::array<std::array<double, kSamples>, kAxes> nats{};

  /// Returns where a sample is along its axis, as a part of the half width, −1 … 1.
  static constexpr double part_of(size_t sample) {
    return 2.0 * static_cast<double>(sample) / (kSamples - 1) - 1;
  }
};

/// Makes profiles of one camera: 145 evaluations of `MonitorDependence` each. The profiles of one
/// image compare the same returns, so that those of several calibrations can be compared.
/// Single-threaded; allocates nothing after the largest image and sweep.
class ProfileSampler {
 public:
  /// `camera.invalid()` and `options.invalid()` must be empty.
  ProfileSampler(const CameraIntrinsics& camera, const ProfileOptions& options);

  /// Prepares an image (kGrey8) and the returns of its sweep as of its exposure; those are compared
  /// that are in view under `T_camera_lidar`. Returns why there is no profile, or an empty text
  /// (static).
  const char* prepare(const CameraFrame& grey, const SweepView& sweep,
                      const Eigen::Isometry3d& T_camera_lidar);

  /// Returns the profile around a pose near the one of `prepare`, which has succeeded.
  DependenceProfile sample(const Eigen::Isometry3d& T_camera_lidar);

  const ProfileOptions& options() const { return options_; }

 private:
  ProfileOptions options_;
  geometry::CameraModel camera_;
  int step_;
  features::RingDirections rings_;
  MonitorImage image_;
  MonitorPoints points_;
  MonitorDependence dependence_;
};

}  // namespace infuse::monitoring
