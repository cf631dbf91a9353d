#include <cmath>

#include "fusion/streetmap/tracker.hpp"

namespace infuse::streetmap {

const char* name_of(TrackState state) {
  switch (state) {
    case TrackState::kUnsure:
      return "UNSURE";
    case TrackState::kTracking:
      return "TRACKING";
    case TrackState::kLost:
      return "LOST";
  }
  return "LOST";
}

Eigen::Isometry3d TrackerEstimate::T_map_vehicle() const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() << pose.x, pose.y, 0;
  return T;
}

geometry::Matrix6 TrackerEstimate::pose_covariance() const {
  // The estimate's covariance is that of x, y, yaw; a left perturbation rotates about the map
  // origin: t' = t + dt + rz × t, so that dt = d(x, y) − rz × (x, y).
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J(0, 2) = pose.y;
  J(1, 2) = -pose.x;
  const Eigen::Matrix3d planar = J * covariance * J.transpose();
  constexpr int kOrder[3] = {3, 4, 2};  // x, y, yaw among (rx, ry, rz, tx, ty, tz)
  geometry::Matrix6 result = geometry::Matrix6::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result(kOrder[i], kOrder[k]) = planar(i, k);
  }
  result(0, 0) = result(1, 1) = 0.05 * 0.05;
  result(5, 5) = 1;
  return result;
}

// Of a pose on the map, with the error of the map, m².
Eigen::Matrix2d Tracker::position_covariance(const PoseMoments& moments) const {
  const double map_variance = options_.confidence.map_sigma * options_.confidence.map_sigma;
  return moments.covariance.topLeftCorner<2, 2>() + map_variance * Eigen::Matrix2d::Identity();
}

TrackerEstimate Tracker::estimate() const {
  TrackerEstimate estimate;
  estimate.state = state_;
  estimate.reason = reason_;
  if (searching_streets_) estimate.hypotheses = global_start_->hypotheses();
  if (!started_) return estimate;
  const PoseMoments moments = particles_.moments();
  estimate.pose = moments.mean;
  estimate.covariance = moments.covariance;
  estimate.covariance.topLeftCorner<2, 2>() = position_covariance(moments);
  estimate.score = score_;
  estimate.p_value = significance_.p_value();
  estimate.z_score = significance_.mean_z_score();
  estimate.entropy = particles_.entropy();
  estimate.elsewhere = place_check_.running() ? place_check_.elsewhere() : 0;
  estimate.gnss_offset = gnss_.offset();
  estimate.gnss_offset_sigma = gnss_.offset_sigma();
  estimate.gnss_contradicts = gnss_.verdict() != GnssWitness::Verdict::kNone;
  estimate.on_map = map_.covers(moments.mean.x, moments.mean.y);
  estimate.updates = updates_since_start_;
  estimate.particles = static_cast<int>(particles_.all().size());
  return estimate;
}

}  // namespace infuse::streetmap
