#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fusion/registration/gauss_newton.hpp"
#include "fusion/registration/lidar_odometry_options.hpp"
#include "fusion/registration/pose_prior.hpp"
#include "fusion/registration/registration_result.hpp"

namespace infuse::registration {

/// Registers points to the planes of a local map, by a robust kernel that narrows from step to
/// step. Does not allocate once it has seen as many points.
class MapRegistration {
 public:
  /// `options.invalid()` must be empty.
  explicit MapRegistration(const LidarOdometryOptions& options) : options_(options) {}

  /// Finds the lidar's pose in the map near the guess. `prior` is about `map.anchor` of the guess's
  /// position. The result's covariance is about the lidar's position, in the map's axes.
  RegistrationResult align(const VoxelMap& map, const PointCloud& points,
                           const Eigen::Isometry3d& T_map_lidar_guess,
                           const std::optional<PosePrior>& prior);

  /// A few steps from a guess among many: `overlap` says how well it fits. Without covariance.
  RegistrationResult attempt(const VoxelMap& map, const PointCloud& points,
                             const Eigen::Isometry3d& T_map_lidar_guess);

  /// Fraction of the points of the last registration that lie on planes of the map, 0 … 1.
  double overlap() const { return overlap_; }

  /// Weight of each point of the last registration, 0 … 1: 1 on a plane of the map, 0 without one.
  /// Their mean is `overlap`.
  void point_weights(FieldVector<float>& weights) const;

  /// Weight of a prior beside the sums over points. A point's distance from its plane counts in
  /// units of `robust_width` beside it: what is smaller is mostly common to neighbouring points.
  double prior_scale() const;

 private:
  struct Method;
  std::optional<Linearisation> iterate(Method& method, int max_iterations,
                                       RegistrationResult& result);

  LidarOdometryOptions options_;
  Pairs pairs_;
  FieldVector<float> searched_x_, searched_y_, searched_z_;  // m, where its plane was last sought
  std::vector<int32_t> which_;
  ClusterGradients clusters_;
  double overlap_ = 0;
};

}  // namespace infuse::registration
