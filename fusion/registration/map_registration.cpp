#include "fusion/registration/map_registration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fusion/registration/acceleration.hpp"
#include "fusion/registration/move_points.hpp"

namespace infuse::registration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr float kSearchAgain = 0.03F;  // m; a point that moved less keeps its plane
// Weight of the directions along a plane: small, so that a point may slide on it.
constexpr double kPlaneVariance = 1e-4;
constexpr int kSearchIterations = 12;  // bounds time: planes may come and go
constexpr int kAttemptIterations = 6;
// Ranges that are noise lie near planes that noise made: the best of all poses then has points 1.5
// times as near as if their distances were uniform; walls and ground have them 4 times as near.
constexpr double kBetterThanChance = 2;
constexpr const char* kTooFew = "too few points lie on planes of the map";

/// Mean weight of points whose distances d from their planes are uniform: ∫ (1 + (d / width)²)⁻²
/// from 0 to the radius within which a plane is sought, over that radius.
double weight_by_chance(const LidarOdometryOptions& options) {
  return 0.25 * std::numbers::pi * options.robust_width / options.final_radius;
}

/// From the anchor to the lidar's position.
void set_origin_to_lidar(const Eigen::Vector3d& anchor, RegistrationResult& result) {
  Eigen::Isometry3d T_lidar_anchor = Eigen::Isometry3d::Identity();
  T_lidar_anchor.translation() = anchor - result.T_target_source.translation();
  const Matrix6 move = geometry::adjoint(T_lidar_anchor);
  const Matrix6 back = geometry::adjoint(T_lidar_anchor.inverse());
  result.covariance = move * result.covariance * move.transpose();
  result.information = back.transpose() * result.information * back;
}

}  // namespace

/// One registration, as `gauss_newton` takes it.
struct MapRegistration::Method {
  MapRegistration& owner;
  const VoxelMap& map;
  const PointCloud& points;
  Eigen::Vector3d anchor;
  std::optional<PosePrior> prior;
  bool attempt;  ///< attempts are compared by their weights, so all end with the same width
  int iterations = 0;
  double radius = owner.options_.radius;
  MapPlaneFactor plane{{.noise = {.plane_variance = kPlaneVariance,
                                  .robust_width = owner.options_.first_robust_width}}};
  Acceleration acceleration{};

  const Eigen::Vector3d& origin() const { return anchor; }
  const Pairs& pairs() const { return owner.pairs_; }
  const MapPlaneFactor& factor() const { return plane; }

  void forget_planes() {
    for (FieldVector<float>* field : {&owner.searched_x_, &owner.searched_y_, &owner.searched_z_}) {
      std::fill(field->begin(), field->end(), std::numeric_limits<float>::infinity());
    }
  }

  const char* match(const Eigen::Isometry3d& T_anchor_lidar) {
    Pairs& pairs = owner.pairs_;
    FieldVector<float>&x = owner.searched_x_, &y = owner.searched_y_, &z = owner.searched_z_;
    move_points(T_anchor_lidar, points.points(), pairs.px, pairs.py, pairs.pz);
    owner.which_.clear();
    const bool settling = iterations >= kSearchIterations;
    for (size_t i = 0; i < pairs.size; ++i) {
      const float dx = pairs.px[i] - x[i], dy = pairs.py[i] - y[i], dz = pairs.pz[i] - z[i];
      const bool known = dx * dx + dy * dy + dz * dz < kSearchAgain * kSearchAgain ||
                         (settling && std::isfinite(x[i]));
      if (known) continue;
      owner.which_.push_back(static_cast<int32_t>(i));
      x[i] = pairs.px[i], y[i] = pairs.py[i], z[i] = pairs.pz[i];
    }
    map.find_planes(anchor, radius, owner.which_, pairs);
    return "";
  }

  std::optional<Vector6> step(const Linearisation& at, const Eigen::Isometry3d& T_anchor_lidar) {
    const Vector6 step = prior ? step_with_prior(at.system, at.determined, T_anchor_lidar, *prior)
                               : determined_step(at.system, at.determined);
    if (!step.allFinite() || at.determined.count == 0) return std::nullopt;
    return acceleration.factor(step) * step;
  }

  bool settled(const Linearisation&, const Vector6& step, bool small) {
    ++iterations;
    double& width = plane.noise.robust_width;
    const bool narrow = width <= owner.options_.robust_width;
    const double moved = kLever * step.head<3>().norm() + step.tail<3>().norm();
    if (attempt || moved < width) width = std::max(0.5 * width, owner.options_.robust_width);
    if (!narrow || radius <= owner.options_.final_radius) return small && narrow;
    radius = owner.options_.final_radius;
    acceleration = {};
    forget_planes();
    return false;
  }
};

double MapRegistration::prior_scale() const {
  return options_.robust_width * options_.robust_width / (2 * kPlaneVariance);
}

std::optional<Linearisation> MapRegistration::iterate(Method& method, int max_iterations,
                                                      RegistrationResult& result) {
  const size_t size = method.points.size();
  overlap_ = 0;
  result.points = size;
  pairs_.resize(size);
  for (FieldVector<float>* field : {&searched_x_, &searched_y_, &searched_z_}) {
    reserve_with_headroom(*field, size);
    field->resize(size);
  }
  method.forget_planes();
  reserve_with_headroom(which_, size);
  const StepLimits limits{.max_iterations = max_iterations,
                          .rotation_tolerance = options_.rotation_tolerance,
                          .translation_tolerance = options_.translation_tolerance,
                          .min_plane_fraction = options_.min_plane_fraction};
  const std::optional<Linearisation> last = gauss_newton(method, limits, result);
  if (!last) {
    result.reason = kTooFew;
    return last;
  }
  result.inliers = static_cast<size_t>(
      std::count_if(pairs_.weight.begin(), pairs_.weight.end(), [](float w) { return w > 0; }));
  overlap_ = last->system.weight / static_cast<double>(std::max<size_t>(size, 1));
  return last;
}

RegistrationResult MapRegistration::align(const VoxelMap& map, const PointCloud& points,
                                          const Eigen::Isometry3d& T_map_lidar_guess,
                                          const std::optional<PosePrior>& prior) {
  RegistrationResult result;
  result.T_target_source = T_map_lidar_guess;
  const Eigen::Vector3d anchor = map.anchor(T_map_lidar_guess.translation());
  Method method{*this, map, points, anchor, prior, false};
  const std::optional<Linearisation> last = iterate(method, options_.max_iterations, result);
  if (!last) return result;
  clusters_.sum(pairs_, method.factor());
  set_uncertainty(clusters_, last->system, last->determined, result);
  set_origin_to_lidar(anchor, result);
  result.reason = "";
  if (result.inliers < options_.min_inliers) {
    result.reason = kTooFew;
  } else if (last->system.weight <
             kBetterThanChance * weight_by_chance(options_) * static_cast<double>(result.inliers)) {
    result.reason = "the points lie on planes of the map no better than by chance";
  } else if (!result.converged) {
    result.reason = "the registration did not converge";
  }
  return result;
}

RegistrationResult MapRegistration::attempt(const VoxelMap& map, const PointCloud& points,
                                            const Eigen::Isometry3d& T_map_lidar_guess) {
  RegistrationResult result;
  result.T_target_source = T_map_lidar_guess;
  Method method{*this, map, points, map.anchor(T_map_lidar_guess.translation()), {}, true};
  iterate(method, kAttemptIterations, result);
  return result;
}

void MapRegistration::point_weights(FieldVector<float>& weights) const {
  reserve_with_headroom(weights, pairs_.size);
  weights.resize(pairs_.size);
  const auto width2 = static_cast<float>(options_.robust_width * options_.robust_width);
  const Pairs& at = pairs_;
  for (size_t i = 0; i < pairs_.size; ++i) {
    const float distance = at.tx[i] * (at.px[i] - at.qx[i]) + at.ty[i] * (at.py[i] - at.qy[i]) +
                           at.tz[i] * (at.pz[i] - at.qz[i]);
    const float kernel = width2 / (width2 + distance * distance);
    weights[i] = at.weight[i] > 0 ? kernel * kernel : 0;
  }
}

}  // namespace infuse::registration
