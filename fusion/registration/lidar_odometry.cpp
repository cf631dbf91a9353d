#include "fusion/registration/lidar_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/measurement/rotation.hpp"
#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::registration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kMinOverlap = 0.3;  // of an estimate that is closer than the guess
// An overlap below this share of the usual one means a wrong maximum, as after a turn that was too
// fast to follow. Sweeps that are added at such poses blur the map (decision 10).
constexpr double kLostShare = 0.5;
constexpr double kOverlapRise = 0.5, kOverlapFall = 0.1;  // shares by which a sweep changes it
constexpr double kUnknown = 1e6;    // rad², m²: variance of a pose that is a guess
constexpr int kMaxStartSteps = 50;  // each way; bounds time: the second sweep may come late
constexpr double kStartSigmas = 3;  // by which a start fits better than a slower one (decision 10)
constexpr double kFiner = 1.5;      // step to a smaller voxel

/// Inverse of a covariance. Directions with a standard deviation above 1 (rad, m) are free: they
/// have no information.
Matrix6 information_of(const Matrix6& covariance) {
  const auto eigen = geometry::symmetric_eigen<6>(covariance);
  Vector6 inverse;
  for (int i = 0; i < 6; ++i) {
    const double variance = eigen.values[i];
    inverse[i] = variance > 0 && variance < 1 ? 1 / variance : 0;
  }
  return eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose();
}

/// Whether points lie on planes better than at another pose: by the sum of the differences of their
/// weights, which is known to about the root of the sum of their squares. What fits both poses, as
/// walls along the street do, does not count.
bool fits_better(const FieldVector<float>& weights, const FieldVector<float>& others) {
  double sum = 0, squares = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    const double difference = weights[i] - others[i];
    sum += difference;
    squares += difference * difference;
  }
  return sum > kStartSigmas * std::sqrt(squares);
}

}  // namespace

LidarOdometry::LidarOdometry(const Eigen::Isometry3d& T_vehicle_lidar,
                             const LidarOdometryOptions& options)
    : T_vehicle_lidar_(T_vehicle_lidar),
      options_(options),
      map_(options.map),
      registration_(options) {}

void LidarOdometry::reset() {
  map_.clear();
  sweeps_ = 0;
  failures_ = 0;
  T_map_vehicle_.setIdentity();
  T_map_located_.setIdentity();
  covariance_.setZero();
  velocity_.setZero();
  usual_overlap_ = 0;
}

void LidarOdometry::select(const geometry::PointsView& points, double voxel_size,
                           size_t min_points) {
  const auto near2 = static_cast<float>(options_.min_range * options_.min_range);
  const auto far2 = static_cast<float>(options_.map.range * options_.map.range);
  thinned_.resize(points.x.size());
  size_t size = 0;
  for (size_t i = 0; i < points.x.size(); ++i) {
    const float x = points.x[i], y = points.y[i], z = points.z[i];
    const float square = x * x + y * y + z * z;
    if (!(square >= near2 && square <= far2)) continue;
    thinned_.x[size] = x, thinned_.y[size] = y, thinned_.z[size] = z;
    ++size;
  }
  thinned_.resize(size);
  for (;; voxel_size /= kFiner) {
    downsampler_.compute(thinned_.points(), voxel_size, selected_, VoxelPoint::kFirst);
    if (selected_.size() >= std::min(min_points, size) ||
        voxel_size < kFiner * options_.min_match_voxel_size) {
      return;
    }
  }
}

Eigen::Isometry3d LidarOdometry::predict(Stamp reference) const {
  return geometry::exp(velocity_ * to_seconds(reference - stamp_));
}

// The prior about the map's anchor at a guess; none after a sweep without a pose.
std::optional<PosePrior> LidarOdometry::anchored(const geometry::MotionBetween* prior,
                                                 const Eigen::Isometry3d& T_map_lidar_guess) const {
  if (prior == nullptr || failures_ > 0) return std::nullopt;
  Eigen::Isometry3d T_anchor_vehicle = T_map_vehicle_;
  T_anchor_vehicle.translation() -= map_.anchor(T_map_lidar_guess.translation());
  return anchored_prior(*prior, T_anchor_vehicle, T_vehicle_lidar_, registration_.prior_scale());
}

// Where the geometry leaves the speed free all fit about as well, and the slowest is the guess.
Eigen::Isometry3d LidarOdometry::search_start(double seconds) {
  const double reach = options_.max_start_speed * seconds / options_.start_step;
  const int steps = static_cast<int>(std::min<double>(reach, kMaxStartSteps));
  starts_.resize(static_cast<size_t>(2 * steps + 1));
  for (int i = -steps; i <= steps; ++i) {
    Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
    T_from_to.translation().x() = i * options_.start_step;
    const Eigen::Isometry3d guess = T_map_vehicle_ * T_from_to * T_vehicle_lidar_;
    const RegistrationResult result = registration_.attempt(map_, selected_, guess);
    Start& start = starts_[static_cast<size_t>(i + steps)];
    start.T_from_to =
        T_map_vehicle_.inverse() * result.T_target_source * T_vehicle_lidar_.inverse();
    start.weight = registration_.overlap() * static_cast<double>(selected_.size());
    registration_.point_weights(start.weights);
  }
  const Start& best = *std::ranges::max_element(starts_, {}, &Start::weight);
  Eigen::Isometry3d slowest = best.T_from_to;
  for (const Start& start : starts_) {
    if (fits_better(best.weights, start.weights)) continue;
    if (start.T_from_to.translation().norm() < slowest.translation().norm())
      slowest = start.T_from_to;
  }
  return slowest;
}

LidarOdometryResult LidarOdometry::align(const geometry::PointsView& points, Stamp reference,
                                         const std::optional<Eigen::Isometry3d>& T_from_to_guess,
                                         const geometry::MotionBetween* prior) {
  LidarOdometryResult result;
  result.stamp = reference;
  result.motion.from = stamp_;
  result.motion.to = reference;
  result.T_map_vehicle = T_map_vehicle_;
  select(points, options_.match_voxel_size, options_.min_match_points);
  if (selected_.size() < options_.min_inliers) {
    result.reason = "the sweep has too few points";
    return result;
  }
  if (map_.empty()) {
    result.reason = "the first sweep starts the map";
    return result;
  }
  const double seconds = to_seconds(reference - stamp_);
  if (!(seconds > 0 && reference > located_stamp_)) {
    result.reason = "the sweep is not later than the one before";
    return result;
  }
  // Where nothing is found, as between bare walls, the next search waits for the next map: it costs
  // a hundred registrations.
  const bool first_pair = sweeps_ == 1 && failures_ == 0;
  const Eigen::Isometry3d guess = T_from_to_guess ? *T_from_to_guess
                                  : first_pair    ? search_start(seconds)
                                                  : predict(reference);
  const Eigen::Isometry3d T_map_lidar_guess = T_map_vehicle_ * guess * T_vehicle_lidar_;
  result.registration =
      registration_.align(map_, selected_, T_map_lidar_guess, anchored(prior, T_map_lidar_guess));
  result.overlap = registration_.overlap();
  result.reason = result.registration.reason;
  const double lost_overlap = kLostShare * usual_overlap_;
  if (result.usable() && result.overlap < lost_overlap)
    result.reason = "far fewer points lie on planes of the map than before";
  result.unsettled = !result.registration.converged &&
                     result.overlap > std::max(kMinOverlap, lost_overlap) &&
                     result.registration.inliers >= options_.min_inliers;
  result.motion.T_from_to = guess;
  if (result.usable() || result.unsettled) {
    result.motion.T_from_to =
        T_map_vehicle_.inverse() * result.registration.T_target_source * T_vehicle_lidar_.inverse();
  }
  if (result.usable()) {
    // Both sweeps' errors, about the lidar's position in the map's axes, as those of the vehicle
    // at `from`.
    Eigen::Isometry3d T_from_lidar = T_map_vehicle_.inverse();
    T_from_lidar.translation() =
        T_map_vehicle_.inverse() * result.registration.T_target_source.translation();
    result.motion.information = information_of(
        geometry::transform_covariance(T_from_lidar, result.registration.covariance + covariance_));
  }
  result.T_map_vehicle = T_map_vehicle_ * result.motion.T_from_to;
  result.T_map_vehicle.linear() = orthonormal(result.T_map_vehicle.linear());
  result.velocity = geometry::log(T_map_located_.inverse() * result.T_map_vehicle) /
                    to_seconds(reference - located_stamp_);
  return result;
}

void LidarOdometry::add(const geometry::PointsView& points, const LidarOdometryResult& result) {
  const bool first = map_.empty();
  T_map_vehicle_ = result.T_map_vehicle;
  stamp_ = result.stamp;
  if (!first && !result.usable() && ++failures_ < options_.max_failures) {
    covariance_ = kUnknown * Matrix6::Identity();
    return;
  }
  failures_ = 0;
  if (result.usable()) {
    velocity_ = result.velocity;
    covariance_ = result.registration.covariance;
    const double rate = result.overlap > usual_overlap_ ? kOverlapRise : kOverlapFall;
    usual_overlap_ += rate * (result.overlap - usual_overlap_);
  } else {
    map_.clear();
    sweeps_ = 0;
    velocity_.setZero();
    covariance_.setZero();
    usual_overlap_ = 0;
  }
  T_map_located_ = T_map_vehicle_;
  located_stamp_ = stamp_;
  const Eigen::Isometry3d T_map_lidar = T_map_vehicle_ * T_vehicle_lidar_;
  map_.drop_far(T_map_lidar.translation());
  select(points, options_.map_voxel_size, 0);
  map_.insert(selected_.points(), T_map_lidar);
  ++sweeps_;
}

}  // namespace infuse::registration
