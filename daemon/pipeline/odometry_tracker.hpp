#pragma once

#include "daemon/config/odometry_settings.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
#include "daemon/protocol/reports.hpp"
#include "fusion/motion/gyro_axes.hpp"
#include "fusion/motion/odometry_filter.hpp"

namespace infuse::daemon {

/// Dead reckoning on the fusion thread, in the frame `odom`: origin at the start of the drive, x
/// ahead, no jumps. The heading of that frame is unknown: a GNSS course measures its changes only.
class OdometryTracker {
 public:
  /// The settings are those of `plan_odometry`; `T_vehicle_lidar` is the mounting of the lidar
  /// whose motion is added.
  explicit OdometryTracker(
      const OdometrySettings& settings,
      const Eigen::Isometry3d& T_vehicle_lidar = Eigen::Isometry3d::Identity());

  /// True if the motion that a lidar measures is added.
  bool uses_lidar() const { return uses_lidar_; }
  /// True if it is wanted now: also while wheels rest, for a vehicle that is carried stands by its
  /// wheels, and a gyro does not contradict them on a straight way.
  bool wants_lidar() const { return uses_lidar_ || wheels_rest_; }

  /// Adds a sample; samples of different sensors may be out of order by the reordering time.
  void add(const VehicleSample& sample);

  /// Requests a pose at the end of a sweep, from which and to which the lidar measures motion if
  /// `clone` is true.
  void mark(Stamp end, bool clone) { filter_.mark(end, clone); }

  /// Processes samples and marks up to a time; beyond the samples the motion is predicted.
  void process_until(Stamp end) { filter_.process_until(end); }

  /// Adds the motion between two marks.
  void add(const motion::RelativePose& pose) {
    filter_.add(pose);
    gyro_axes_.add(pose);
  }

  /// Processes the samples that still wait for earlier ones.
  void finish() { filter_.flush(); }

  /// True while wheels measure the speed.
  bool has_wheels() const { return filter_.has_wheels(); }
  /// True while they measure the motion in all directions of the model, and are not suspended.
  bool wheels_measure_motion() const { return filter_.wheels_measure_motion(); }

  /// Poses of the vehicle in the frame `odom`.
  const geometry::Trajectory& trajectory() const { return filter_.trajectory(); }

  /// Where the vehicle is at the time of the last sample or mark, though no source measures it.
  geometry::PoseAt predicted_pose() const { return filter_.predicted_pose(); }

  /// Returns the pose at `stamp` in the frame `odom`.
  PoseReport pose_at(Stamp stamp) const;

  /// Makes a pose of `pose_at` unusable if it is less sure than the settings allow. Its motion
  /// since earlier poses may be used all the same.
  void bound(PoseReport& pose) const;

  /// What is known of the gyros in the lidar's housing.
  const motion::GyroAxes& gyro_axes() const { return gyro_axes_; }

  /// Returns the status for HEALTH at the drive time `now`.
  OdometryStatus status(Stamp now) const;

 private:
  void add_gyros(const GyroReadings& readings);
  void see_rest(const WheelOdometry& sample);
  const char* reason_at(Stamp now) const;

  motion::OdometryFilter filter_;
  bool uses_lidar_;
  double standstill_speed_;     // m/s
  bool wheels_rest_ = false;    // by the last sample
  motion::GyroAxes gyro_axes_;  // of the lidar
  bool has_inertial_unit_ = false;
  bool use_gnss_speed_;
  double max_heading_sigma_;
  Duration max_silence_, max_gnss_silence_;
};

}  // namespace infuse::daemon
