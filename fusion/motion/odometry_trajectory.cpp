#include "fusion/motion/odometry_trajectory.hpp"

namespace infuse::motion {
namespace {

using geometry::StampedPose;

constexpr Duration kLead{10'000'000};  // of the first pose

/// Where a time lies between two poses: 0 at `a`, 1 at `b`.
double share(const StampedPose& a, const StampedPose& b, Stamp stamp) {
  return to_seconds(stamp - a.stamp) / to_seconds(b.stamp - a.stamp);
}

StampedPose between(const StampedPose& a, const StampedPose& b, Stamp stamp,
                    const Eigen::Isometry3d& T_odom_vehicle) {
  const double u = share(a, b, stamp);
  return {stamp, T_odom_vehicle, (1 - u) * a.covariance + u * b.covariance,
          (1 - u) * a.steps + u * b.steps};
}

StampedPose interpolated(const StampedPose& a, const StampedPose& b, Stamp stamp) {
  return between(a, b, stamp,
                 geometry::interpolate(a.T_odom_vehicle, b.T_odom_vehicle, share(a, b, stamp)));
}

}  // namespace

void OdometryTrajectory::extend(const OdometryState& state, Stamp now, Duration interval) {
  if (!poses_.empty() && now - poses_[poses_.size() - 1].stamp < interval) return;
  poses_.append({now, state.T_odom_vehicle(), state.pose_covariance(), steps_});
}

void OdometryTrajectory::correct(const RelativePose& pose, const RelativePoseUpdate& update,
                                 const OdometryState& state, Stamp now_stamp) {
  const geometry::PoseAt before = poses_.at(pose.from);
  if (before.usable()) steps_ = before.steps;
  const StampedPose from{pose.from, *state.cloned_pose(pose.from),
                         state.cloned_covariance(pose.from), steps_};
  steps_ += update.motion_covariance;
  const StampedPose to{pose.to, *state.cloned_pose(pose.to), state.cloned_covariance(pose.to),
                       steps_};
  const StampedPose now{now_stamp, state.T_odom_vehicle(), state.pose_covariance(), steps_};
  for (size_t i = poses_.index_at_or_after(pose.from); i < poses_.size(); ++i) {
    const StampedPose& old = poses_[i];
    if (old.stamp <= from.stamp) continue;
    const bool within = old.stamp <= to.stamp;
    geometry::Vector6 change = share(from, to, old.stamp) * update.change_at_to;
    if (!within) {
      change = update.change_at_to +
               share(to, now, old.stamp) * (update.change_at_now - update.change_at_to);
    }
    poses_.correct(i, between(within ? from : to, within ? to : now, old.stamp,
                              geometry::exp(change) * old.T_odom_vehicle));
  }
  // Consecutive sweeps may overlap by a firing: the trajectory begins a little before.
  if (poses_.empty()) {
    StampedPose first = interpolated(from, to, from.stamp - kLead);
    first.covariance = from.covariance;
    first.steps = from.steps;
    poses_.append(first);
  }
  for (Stamp stamp = from.stamp; stamp < to.stamp; stamp = stamp + kPredictedInterval) {
    poses_.append(interpolated(from, to, stamp));
  }
  poses_.append(to);
  if (now.stamp > to.stamp) extend(state, now_stamp, pose_interval_);
}

void OdometryTrajectory::correct_since(Stamp since, Stamp now, const geometry::Vector6& change) {
  const auto moved = [&](double share) {
    const geometry::Vector6 part = share * share * change;
    return geometry::Matrix6(part * part.transpose());
  };
  for (size_t i = poses_.index_at_or_after(since); i < poses_.size(); ++i) {
    StampedPose pose = poses_[i];
    const double share = to_seconds(pose.stamp - since) / to_seconds(now - since);
    pose.T_odom_vehicle = geometry::exp(share * share * change) * pose.T_odom_vehicle;
    pose.covariance += moved(share);
    pose.steps += moved(share);
    poses_.correct(i, pose);
  }
  steps_ += moved(1);
}

}  // namespace infuse::motion
