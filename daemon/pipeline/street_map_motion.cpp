#include "daemon/pipeline/street_map_motion.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::daemon {
namespace {

constexpr double kScaleSigma = 0.006;    // m/m, scale of odometry
constexpr double kRestSigma = 0.005;     // m
constexpr double kYawRateSigma = 0.002;  // rad/s, bias of odometry

/// Covariance of x, y and yaw.
Eigen::Matrix3d planar(const geometry::Matrix6& covariance) {
  constexpr int kOrder[3] = {3, 4, 2};
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result(i, k) = covariance(kOrder[i], kOrder[k]);
  }
  return result;
}

/// Noise of one step that is measured: covariance of x, y and yaw. The covariance of a motion is
/// the growth of the pose's covariance (Trajectory::between). Lasting errors (scale, bias) make it
/// grow ever faster, and drawing it at each step would count them many times; the particles carry
/// those. The standard deviations are therefore limited to what a wrong scale and a wrong rate
/// cause within one step.
Eigen::Matrix3d step_noise(const geometry::MotionBetween& motion, Duration step) {
  const double distance = motion.T_from_to.translation().norm();
  const double max_sigma[3] = {kScaleSigma * distance + kRestSigma,
                               kScaleSigma * distance + kRestSigma,
                               kYawRateSigma * to_seconds(step)};
  Eigen::Matrix3d result = planar(motion.covariance);
  for (int i = 0; i < 3; ++i) {
    const double sigma = std::sqrt(std::max(result(i, i), 0.0));
    if (sigma <= max_sigma[i]) continue;
    result.row(i) *= max_sigma[i] / sigma;
    result.col(i) *= max_sigma[i] / sigma;
  }
  return result;
}

}  // namespace

streetmap::PlanarPose planar(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T(1, 0), T(0, 0))};
}

// In a gap the covariance is that of an unseen motion, which grows once: it is not limited.
void StreetMapMotion::predict(streetmap::Tracker& tracker, const geometry::Trajectory& trajectory,
                              const geometry::PoseAt& predicted, Stamp to) {
  geometry::PoseAt pose = trajectory.at(to);
  if (!pose.usable()) pose = predicted;
  if (now_ != Stamp::earliest() && to > now_) {
    geometry::MotionBetween motion = trajectory.between(now_, to);
    const bool measured = motion.usable();
    if (!measured) motion = geometry::motion_between(last_, pose);
    tracker.predict(planar(motion.T_from_to),
                    measured ? step_noise(motion, to - now_) : planar(motion.covariance),
                    to - now_);
  }
  last_ = pose;
  now_ = to;
}

}  // namespace infuse::daemon
