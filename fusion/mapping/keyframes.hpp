#pragma once

#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::mapping {

/// Settings of the choice of keyframes and of the uncertainty of the motion between them.
struct KeyframeOptions {
  double distance = 2;    ///< m from the keyframe before, at which a sweep becomes a keyframe …
  double rotation = 0.2;  ///< rad; … or turned by so much
  /// Drift of the odometry's local map, which a sweep's registration to it does not state: standard
  /// deviations after 1 m, growing with the root of the distance driven.
  double rotation_drift = 1e-3;     ///< rad/√m
  double translation_drift = 2e-2;  ///< m/√m
  /// Standard deviations of a motion that was not measured, by time.
  double unmeasured_rotation = 0.2;     ///< rad/s
  double unmeasured_translation = 3.0;  ///< m/s

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Pose of the vehicle that a map is made of.
struct Keyframe {
  Stamp stamp;
  Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();
  double distance_driven = 0;  ///< m driven since the first keyframe
  /// Covariance of the motion since the keyframe before: left perturbation in the vehicle frame
  /// there, (rx, ry, rz, tx, ty, tz), rad and m; zero for the first.
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
  bool has_cloud = true;  ///< false where others see the same: only the pose is kept
};

/// Motion of the vehicle since the sweep before, as odometry states it.
struct SweepMotion {
  Stamp stamp;  ///< of the sweep
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
  /// Left perturbation in the vehicle frame at the sweep before, (rx, ry, rz, tx, ty, tz), rad, m.
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
  bool registered = false;  ///< the lidar measured it
  bool measured = false;    ///< any sensor measured it; else it is not known
};

/// Picks keyframes from what odometry states sweep by sweep.
class KeyframePicker {
 public:
  /// `options.invalid()` must be empty.
  explicit KeyframePicker(const KeyframeOptions& options) : options_(options) {}

  /// Takes the next sweep; returns true if it is a keyframe, which is then `last()`. A sweep whose
  /// motion is not measured is taken to have gone on as before, and is no keyframe.
  bool add(const SweepMotion& motion);

  const Keyframe& last() const { return last_; }
  /// Pose at the last sweep.
  const Eigen::Isometry3d& T_odom_vehicle() const { return T_odom_vehicle_; }
  bool started() const { return started_; }
  double distance_driven() const { return distance_driven_; }
  /// Sweeps since the start whose motion was not measured.
  size_t unmeasured() const { return unmeasured_; }
  /// The same that the lidar did not measure.
  size_t unregistered() const { return unregistered_; }

 private:
  bool is_due() const;

  KeyframeOptions options_;
  Keyframe last_;
  Eigen::Isometry3d T_odom_vehicle_ = Eigen::Isometry3d::Identity();
  geometry::Vector6 velocity_ = geometry::Vector6::Zero();  // twist per second
  // Covariance of the motion since last_.
  geometry::Matrix6 since_last_ = geometry::Matrix6::Zero();
  Stamp stamp_;
  double distance_driven_ = 0;
  size_t unmeasured_ = 0, unregistered_ = 0;
  bool started_ = false;
};

}  // namespace infuse::mapping
