#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {

/// Pose of the vehicle at one time, in the odometry frame `odom` of REP 105.
struct StampedPose {
  Stamp stamp;                                                       ///< of the pose
  Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();  ///< the pose
  Matrix6 covariance = Matrix6::Zero();  ///< left perturbation, odometry frame
  /// Sum of the covariances of the measured steps that led here, which is the least that the
  /// covariance grows by; 0 where no steps are measured.
  Matrix6 steps = Matrix6::Zero();
};

/// Settings of a trajectory.
struct TrajectoryOptions {
  size_t capacity = 4096;         ///< poses, the oldest are dropped: bounds memory
  Duration max_gap{200'000'000};  ///< ns; the pose between two poses further apart is unknown
  Duration max_extrapolation{0};  ///< ns past the last pose, at its twist
  double rotation_growth = 3e-4;  ///< rad/√s, growth of the standard deviation of an extrapolated
                                  ///< rotation, each axis
  double translation_growth = 0.1;  ///< m/√s, the same for the translation

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

/// Pose at a requested time, or the reason why it is unknown.
struct PoseAt {
  Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();  ///< the pose
  Matrix6 covariance = Matrix6::Zero();  ///< left perturbation, odometry frame
  Matrix6 steps = Matrix6::Zero();       ///< as in `StampedPose`
  const char* reason = "";               ///< static text; empty if the pose is usable

  bool usable() const { return *reason == '\0'; }  ///< it may be used
};

/// Motion between two times, or the reason why it is unknown.
struct MotionBetween {
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();  ///< vehicle at `to` in the frame of
                                                                ///< the vehicle at `from`
  Matrix6 covariance = Matrix6::Zero();  ///< left perturbation, vehicle frame at `from`
  const char* reason = "";               ///< static text; empty if the motion is usable

  bool usable() const { return *reason == '\0'; }  ///< it may be used
};

/// The motion between two poses of one odometry frame. Its covariance is the growth between the
/// two, without the errors common to both, and at least that of the steps. `to` may be the earlier
/// one: `backwards`.
MotionBetween motion_between(const PoseAt& from, const PoseAt& to, bool backwards = false);

/// Bounded, time-ordered sequence of stamped poses `T_odom_vehicle` in the odometry frame. Between
/// two poses the vehicle moves at constant twist and the covariance is interpolated linearly.
class Trajectory {
 public:
  /// `options.invalid()` must be empty. Allocates all memory.
  explicit Trajectory(const TrajectoryOptions& options = {});

  /// Appends a pose; returns false and changes nothing if it is not later than the last.
  bool append(const StampedPose& pose);

  /// Replaces the pose of an index < size() by another of the same time.
  void correct(size_t index, const StampedPose& pose);

  /// Removes all poses; keeps the memory.
  void clear();

  size_t size() const { return size_; }      ///< number of poses
  bool empty() const { return size_ == 0; }  ///< no pose

  /// Poses in time order; index < size().
  const StampedPose& operator[](size_t index) const;

  /// Returns the pose at a time.
  PoseAt at(Stamp stamp) const;

  /// Returns the motion from one time to another; either may be the earlier. Its covariance is the
  /// growth between the two, without the errors common to both, and at least that of the steps.
  MotionBetween between(Stamp from, Stamp to) const;

  /// Returns why a part of the time span is not covered, as static text; empty if all of it is
  /// covered.
  const char* uncovered_reason(Stamp from, Stamp to) const;

  /// Returns the index of the first pose at or after the stamp; size() if there is none.
  size_t index_at_or_after(Stamp stamp) const;

 private:
  PoseAt extrapolate(Stamp stamp) const;

  TrajectoryOptions options_;
  std::vector<StampedPose> ring_;
  size_t first_ = 0;
  size_t size_ = 0;
};

}  // namespace infuse::geometry
