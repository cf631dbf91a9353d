#include "daemon/pipeline/street_map_motion.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::daemon {
namespace {

constexpr double kScaleSigma = 0.006;        // m/m, scale of odometry
constexpr double kRestSigma = 0.005;         // m
constexpr double kYawRateSigma = 0.002;      // rad/s, bias of odometry
constexpr double kNoOdometrySigma = 3.0;     // m, motion of a step without odometry
constexpr double kNoOdometryYawSigma = 0.2;  // rad, the same

/// Noise of one step: covariance of x, y and yaw. The covariance of a motion is the growth of the
/// pose's covariance (Trajectory::between). Lasting errors (scale, bias) make it grow ever faster,
/// and drawing it at each step would count them many times; the particles carry those. The standard
/// deviations are therefore limited to what a wrong scale and a wrong rate cause within one step.
Eigen::Matrix3d step_noise(const geometry::MotionBetween& motion, Duration step) {
  constexpr int kOrder[3] = {3, 4, 2};
  const double distance = motion.T_from_to.translation().norm();
  const double max_sigma[3] = {kScaleSigma * distance + kRestSigma,
                               kScaleSigma * distance + kRestSigma,
                               kYawRateSigma * to_seconds(step)};
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result(i, k) = motion.covariance(kOrder[i], kOrder[k]);
  }
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

void predict(streetmap::Tracker& tracker, const geometry::Trajectory& trajectory, Stamp from,
             Stamp to) {
  const geometry::MotionBetween motion = trajectory.between(from, to);
  if (motion.usable()) {
    return tracker.predict(planar(motion.T_from_to), step_noise(motion, to - from), to - from);
  }
  const Eigen::Vector3d unknown(kNoOdometrySigma * kNoOdometrySigma,
                                kNoOdometrySigma * kNoOdometrySigma,
                                kNoOdometryYawSigma * kNoOdometryYawSigma);
  tracker.predict({}, unknown.asDiagonal(), to - from);
}

}  // namespace infuse::daemon
