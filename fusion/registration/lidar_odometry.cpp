#include "fusion/registration/lidar_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/geometry/symmetric_eigen.hpp"
#include "fusion/registration/move_points.hpp"
#include "fusion/registration/uncertainty.hpp"

namespace infuse::registration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr float kSearchAgain = 0.03F;  // m; a point that moved less keeps its plane
// Weight of the directions along a plane: small, so that a point may slide on it.
constexpr double kPlaneVariance = 1e-4;
constexpr double kLever = 20;          // m, of the points that a rotation moves
constexpr int kSearchIterations = 12;  // planes that come and go could keep it from converging
constexpr double kMinOverlap = 0.3;    // of an estimate that is closer than the guess
// An overlap below this share of the usual one means a wrong maximum, as after a turn that was too
// fast to follow. Sweeps that are added at such poses blur the map.
constexpr double kLostShare = 0.5;
constexpr double kOverlapRise = 0.5, kOverlapFall = 0.1;  // shares by which a sweep changes it
constexpr double kUnknown = 1e6;  // rad², m²: variance of a pose that is a guess
// Errors of a measured motion that are not in its covariance, as those of the times of its samples.
constexpr double kPriorRotationNoise = 3e-4, kPriorTranslationNoise = 2e-2;  // rad, m
constexpr int kStartIterations = 6;
constexpr int kMaxStartSteps = 50;  // each way; the second sweep may come late
constexpr double kStartSigmas = 3;  // by which a start fits better than a slower one
constexpr double kFiner = 1.5;      // step to a smaller voxel

/// Reweighted least squares creep where points leave and enter the robust kernel: each step is a
/// little shorter than the one before. From their ratio follows how far all of them would lead
/// (Aitken's method along the step).
class Acceleration {
 public:
  /// By what to multiply a step.
  double factor(Vector6 step) {
    constexpr double kMaxFactor = 4;
    step.head<3>() *= kLever;
    const double square = last_.squaredNorm();
    double factor = 1;
    if (square > 0) {
      const double left = std::clamp(last_.dot(step) / square, -1.0, 1.0);
      // A step of `factor_` left this share of the distance; a plain one would leave `rate`.
      const double rate = 1 - (1 - left) / factor_;
      factor = std::clamp(1 / std::max(1 - rate, 1e-3), 1.0, kMaxFactor);
    }
    last_ = step;
    factor_ = factor;
    return factor;
  }

 private:
  Vector6 last_ = Vector6::Zero();
  double factor_ = 1;
};

/// Rounding in products of rotations would grow exponentially from sweep to sweep.
void orthonormalise(Eigen::Isometry3d& T) {
  T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
}

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

/// Pose of the lidar that other sensors measured, and the information of its left perturbation in
/// the unit of the sums over points.
struct PosePrior {
  Eigen::Isometry3d T_anchor_lidar;
  Matrix6 information;
};

/// T_anchor_lidar = T_anchor_from T_from_to T_to_lidar: its left perturbation is Ad(T_anchor_from)
/// times that of the motion. `scale` is the weight of the prior beside the sums over points.
PosePrior anchored_prior(const geometry::MotionBetween& motion,
                         const Eigen::Isometry3d& T_anchor_from,
                         const Eigen::Isometry3d& T_vehicle_lidar, double scale) {
  Matrix6 covariance = motion.covariance;
  covariance.diagonal().head<3>().array() += kPriorRotationNoise * kPriorRotationNoise;
  covariance.diagonal().tail<3>().array() += kPriorTranslationNoise * kPriorTranslationNoise;
  const Matrix6 to_motion = geometry::adjoint(T_anchor_from.inverse());
  return {T_anchor_from * motion.T_from_to * T_vehicle_lidar,
          scale * to_motion.transpose() * covariance.ldlt().solve(to_motion)};
}

/// Gauss–Newton step towards the planes in the directions that they determine, and towards the
/// prior in all.
Vector6 step_with_prior(const PoseSystem& system, const DeterminedDirections& determined,
                        const Eigen::Isometry3d& T_anchor_lidar, const PosePrior& prior) {
  const Vector6 to_prior = geometry::log(prior.T_anchor_lidar * T_anchor_lidar.inverse());
  const Matrix6 basis = determined.twist_from_scaled * determined.basis;
  Matrix6 seen = basis;
  seen.rightCols(6 - determined.count).setZero();
  const Matrix6 H = seen.transpose() * (system.planes + system.isotropic) * seen +
                    basis.transpose() * prior.information * basis;
  const Vector6 g =
      seen.transpose() * system.gradient + basis.transpose() * (prior.information * to_prior);
  return basis * H.ldlt().solve(g);
}

}  // namespace

std::optional<std::string> LidarOdometryOptions::invalid() const {
  if (auto wrong = map.invalid()) return wrong;
  if (!(min_range >= 0)) return "min_range must not be negative";
  if (!(map_voxel_size > 0 && match_voxel_size > 0 && min_match_voxel_size > 0))
    return "voxel sizes must be above 0 m";
  if (!(final_radius > 0 && final_radius <= radius && radius <= map.voxel_size))
    return "radii must be above 0 m, final_radius at most radius, radius at most map.voxel_size";
  if (!(robust_width > 0 && robust_width <= first_robust_width))
    return "robust_width must be above 0 and at most first_robust_width";
  if (max_iterations < 1) return "max_iterations must be at least 1";
  if (!(rotation_tolerance > 0 && translation_tolerance > 0)) return "tolerances must be above 0";
  if (!(max_start_speed >= 0 && max_start_speed <= 200)) return "max_start_speed must be 0 ... 200";
  if (!(start_step > 0)) return "start_step must be above 0";
  if (max_failures < 1) return "max_failures must be at least 1";
  return std::nullopt;
}

LidarOdometry::LidarOdometry(const Eigen::Isometry3d& T_vehicle_lidar,
                             const LidarOdometryOptions& options)
    : T_vehicle_lidar_(T_vehicle_lidar), options_(options), map_(options.map) {}

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

RegistrationResult LidarOdometry::register_points(const Eigen::Isometry3d& T_map_lidar_guess,
                                                  int max_iterations, bool final,
                                                  const geometry::MotionBetween* prior) {
  RegistrationResult result;
  overlap_ = 0;
  result.T_target_source = T_map_lidar_guess;
  result.points = selected_.size();
  const Eigen::Vector3d anchor = map_.anchor(T_map_lidar_guess.translation());
  std::optional<PosePrior> anchored;
  if (prior != nullptr) {
    Eigen::Isometry3d T_anchor_vehicle = T_map_vehicle_;
    T_anchor_vehicle.translation() -= anchor;
    // A point's distance from its plane counts in units of `robust_width` beside the prior: what is
    // smaller is mostly common to neighbouring points.
    const double scale = options_.robust_width * options_.robust_width / (2 * kPlaneVariance);
    anchored = anchored_prior(*prior, T_anchor_vehicle, T_vehicle_lidar_, scale);
  }
  PoseSystem system;
  DeterminedDirections determined;
  PairNoise noise{.plane_variance = kPlaneVariance, .robust_width = options_.first_robust_width};
  double radius = options_.radius;
  Acceleration acceleration;
  pairs_.resize(selected_.size());
  for (FieldVector<float>* field : {&searched_x_, &searched_y_, &searched_z_}) {
    reserve_with_headroom(*field, selected_.size());
    field->assign(selected_.size(), std::numeric_limits<float>::infinity());
  }
  reserve_with_headroom(which_, selected_.size());
  while (result.iterations < max_iterations && !result.converged) {
    Eigen::Isometry3d T_anchor_lidar = result.T_target_source;
    T_anchor_lidar.translation() -= anchor;
    move_points(T_anchor_lidar, selected_.points(), pairs_.px, pairs_.py, pairs_.pz);
    which_.clear();
    const bool settling = result.iterations >= kSearchIterations;
    for (size_t i = 0; i < pairs_.size; ++i) {
      const float dx = pairs_.px[i] - searched_x_[i], dy = pairs_.py[i] - searched_y_[i],
                  dz = pairs_.pz[i] - searched_z_[i];
      const bool known = dx * dx + dy * dy + dz * dz < kSearchAgain * kSearchAgain ||
                         (settling && std::isfinite(searched_x_[i]));
      if (known) continue;
      which_.push_back(static_cast<int32_t>(i));
      searched_x_[i] = pairs_.px[i], searched_y_[i] = pairs_.py[i], searched_z_[i] = pairs_.pz[i];
    }
    map_.find_planes(anchor, radius, which_, pairs_);
    system = pose_system(pairs_, noise);
    determined = determined_directions(pairs_, system, noise, options_.min_plane_fraction);
    Vector6 step = anchored ? step_with_prior(system, determined, T_anchor_lidar, *anchored)
                            : determined_step(system, determined);
    if (!step.allFinite() || determined.count == 0) {
      result.reason = "too few points lie on planes of the map";
      return result;
    }
    step *= acceleration.factor(step);
    T_anchor_lidar = geometry::exp(step) * T_anchor_lidar;
    T_anchor_lidar.translation() += anchor;
    result.T_target_source = T_anchor_lidar;
    ++result.iterations;
    const bool small = step.head<3>().norm() <= options_.rotation_tolerance &&
                       step.tail<3>().norm() <= options_.translation_tolerance;
    const bool narrow = noise.robust_width <= options_.robust_width;
    result.converged = small && narrow;
    // The guesses at the start are compared by their weights, so all end with the same width.
    const double moved = kLever * step.head<3>().norm() + step.tail<3>().norm();
    if (!final || moved < noise.robust_width) {
      noise.robust_width = std::max(0.5 * noise.robust_width, options_.robust_width);
    }
    if (narrow && radius > options_.final_radius) {
      radius = options_.final_radius;
      acceleration = {};
      std::fill(searched_x_.begin(), searched_x_.end(), std::numeric_limits<float>::infinity());
      result.converged = false;
    }
  }
  result.inliers = static_cast<size_t>(
      std::count_if(pairs_.weight.begin(), pairs_.weight.end(), [](float w) { return w > 0; }));
  overlap_ = system.weight / static_cast<double>(std::max<size_t>(selected_.size(), 1));
  if (!final) return result;
  set_uncertainty(pairs_, noise, system, determined, clusters_, result);
  // From the anchor to the lidar's position.
  Eigen::Isometry3d T_lidar_anchor = Eigen::Isometry3d::Identity();
  T_lidar_anchor.translation() = anchor - result.T_target_source.translation();
  const Matrix6 move = geometry::adjoint(T_lidar_anchor);
  const Matrix6 back = geometry::adjoint(T_lidar_anchor.inverse());
  result.covariance = move * result.covariance * move.transpose();
  result.information = back.transpose() * result.information * back;
  result.reason = "";
  if (result.inliers < options_.min_inliers) {
    result.reason = "too few points lie on planes of the map";
  } else if (!result.converged) {
    result.reason = "the registration did not converge";
  }
  return result;
}

// The weight of the points on planes is known to about its root. Where the geometry leaves the
// speed free all fit about as well, and the slowest is the guess.
Eigen::Isometry3d LidarOdometry::search_start(double seconds) {
  const double reach = options_.max_start_speed * seconds / options_.start_step;
  const int steps = static_cast<int>(std::min<double>(reach, kMaxStartSteps));
  starts_.clear();
  double best_weight = 0;
  for (int i = -steps; i <= steps; ++i) {
    Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
    T_from_to.translation().x() = i * options_.start_step;
    const Eigen::Isometry3d guess = T_map_vehicle_ * T_from_to * T_vehicle_lidar_;
    const RegistrationResult result = register_points(guess, kStartIterations, false);
    const double weight = overlap_ * static_cast<double>(selected_.size());
    best_weight = std::max(best_weight, weight);
    starts_.push_back(
        {T_map_vehicle_.inverse() * result.T_target_source * T_vehicle_lidar_.inverse(), weight});
  }
  const double min_weight = best_weight - kStartSigmas * std::sqrt(best_weight);
  Eigen::Isometry3d slowest = Eigen::Isometry3d::Identity();
  double shortest = std::numeric_limits<double>::infinity();
  for (const Start& start : starts_) {
    const double way = start.T_from_to.translation().norm();
    if (start.weight < min_weight || way >= shortest) continue;
    shortest = way;
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
  result.registration =
      register_points(T_map_vehicle_ * guess * T_vehicle_lidar_, options_.max_iterations, true,
                      failures_ == 0 ? prior : nullptr);
  result.overlap = overlap_;
  result.reason = result.registration.reason;
  const double lost_overlap = kLostShare * usual_overlap_;
  if (result.usable() && overlap_ < lost_overlap)
    result.reason = "far fewer points lie on planes of the map than before";
  result.unsettled = !result.registration.converged &&
                     overlap_ > std::max(kMinOverlap, lost_overlap) &&
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
  orthonormalise(result.T_map_vehicle);
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
