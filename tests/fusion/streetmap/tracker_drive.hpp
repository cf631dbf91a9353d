#pragma once

#include "fusion/streetmap/tracker.hpp"

#include <cmath>
#include <cstring>

#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap {

using town::sample_view;

inline constexpr Duration kUpdatePeriod{250'000'000};

inline const town::Town& shared_town() {
  static const town::Town kTown = town::build(town::plan());
  return kTown;
}

inline TrackerOptions fast_options() {
  TrackerOptions options;
  options.fit.centres = 25;
  options.fit.sigmas = {1.0, 2.0};
  options.fit.lambdas = {1e-3, 1e-1};
  options.novelty_distance = 0.5;        // each view of the town is independent
  options.particles.scale_sigma = 0.02;  // matches the error of the odometry
  options.particles.distance_noise = 0.03;
  options.particles.yaw_noise = 0.0015;
  options.particles.min_count = 60;
  options.particles.max_count = 250;
  return options;
}

inline Eigen::Matrix3d covariance(double metres, double yaw) {
  return Eigen::Vector3d(metres * metres, metres * metres, yaw * yaw).asDiagonal();
}

/// Result of a drive along the first street and into the second.
struct DriveResult {
  double rms = 0;      ///< m, after the first ten updates
  double yaw_rms = 0;  ///< rad
  int tracking = 0, updates = 0, within = 0, first_tracking = -1;
  bool places_named = false;  ///< a reason named a place along, across or elsewhere
  PlanarPose truth, last;
  TrackState state = TrackState::kLost;
};

/// 60 updates of 2 m with a turn at the crossing. The odometry has a scale error of 2 % and a yaw
/// bias of 0.1° per update.
inline DriveResult drive(Tracker& tracker, const PlanarPose& start_error, double sigma,
                         uint64_t seed, int updates = 60, bool gnss = false) {
  DriveResult driven;
  PlanarPose truth{-80, -1.2, 0.02};
  const PlanarPose initial_pose = truth.compose(start_error);
  tracker.start(initial_pose, covariance(sigma, 0.06));
  double sum = 0, yaw_sum = 0;
  int counted = 0;
  for (int i = 0; i < updates; ++i) {
    const bool turning = truth.x > -6 && truth.yaw < 1.5;
    const PlanarPose motion{2, 0, turning ? 0.35 : (truth.yaw < 0.5 ? -0.05 * truth.yaw : 0)};
    truth = truth.compose(motion);
    tracker.predict({motion.x * 1.02, motion.y, motion.yaw + 0.0017}, covariance(0.02, 0.002),
                    kUpdatePeriod);
    tracker.update(sample_view(shared_town().map, truth, seed * 1000 + static_cast<uint64_t>(i)));
    if (gnss) tracker.add_fix({{truth.x + 2, truth.y - 1.5}, {}, 1});
    const TrackerEstimate estimate = tracker.estimate();
    const PlanarPose error = truth.motion_to(estimate.pose);
    ++driven.updates;
    driven.places_named |= std::strstr(estimate.reason, "not confirmed") != nullptr;
    if (estimate.state == TrackState::kTracking) {
      if (driven.first_tracking < 0) driven.first_tracking = i;
      ++driven.tracking;
      const Eigen::Vector2d d(estimate.pose.x - truth.x, estimate.pose.y - truth.y);
      const Eigen::Matrix2d C = estimate.covariance.topLeftCorner<2, 2>();
      driven.within += d.dot(C.inverse() * d) < 9.21;  // χ² of two, 99 %
    }
    if (i < 10) continue;
    ++counted;
    sum += error.x * error.x + error.y * error.y;
    yaw_sum += error.yaw * error.yaw;
  }
  driven.rms = std::sqrt(sum / counted);
  driven.yaw_rms = std::sqrt(yaw_sum / counted);
  driven.truth = truth;
  driven.last = tracker.estimate().pose;
  driven.state = tracker.estimate().state;
  return driven;
}

}  // namespace infuse::streetmap
