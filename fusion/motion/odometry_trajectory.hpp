#pragma once

#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/odometry_state.hpp"

namespace infuse::motion {

/// Trajectory of dead reckoning, which measurements of motion in the past correct.
class OdometryTrajectory {
 public:
  static constexpr Duration kPredictedInterval{100'000'000};  ///< between poses without samples

  OdometryTrajectory(const geometry::TrajectoryOptions& options, Duration pose_interval)
      : poses_(options), pose_interval_(pose_interval) {}

  const geometry::Trajectory& poses() const { return poses_; }
  void clear() { poses_.clear(); }

  /// Appends the pose of `state` at `now` if the last pose is at least `interval` older.
  void extend(const OdometryState& state, Stamp now, Duration interval);

  /// The pose of `state`, as `extend` would append it.
  geometry::PoseAt pose(const OdometryState& state) const {
    return {state.T_odom_vehicle(), state.pose_covariance(), steps_};
  }

  /// Applies what a relative pose changed in `state`, which is as of `now`: poses since then move
  /// by the change, in proportion to time. Poses are added where the trajectory begins only now
  /// that the motion is known.
  void correct(const RelativePose& pose, const RelativePoseUpdate& update,
               const OdometryState& state, Stamp now);

  /// Moves poses after `since` by `change` (left perturbation at `now`) times the square of the
  /// time: an error of the speed that has grown since. It is as uncertain as it is large.
  void correct_since(Stamp since, Stamp now, const geometry::Vector6& change);

 private:
  geometry::Trajectory poses_;
  Duration pose_interval_;
  geometry::Matrix6 steps_ = geometry::Matrix6::Zero();  // of the last pose
};

}  // namespace infuse::motion
