#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fusion/registration/covariance.hpp"
#include "fusion/registration/neighbour_search.hpp"
#include "fusion/registration/pose_system.hpp"
#include "fusion/registration/registration_result.hpp"
#include "fusion/registration/voxel_downsample.hpp"

namespace infuse::registration {

/// A cloud that is prepared for registration: downsampled, with its local planes and its tree.
struct PreparedCloud {
  PointCloud cloud;
  NeighbourSearch search;
};

/// Settings of the preparation.
struct PrepareOptions {
  double voxel_size = 0.25;      ///< m; 0: keep every point that is finite
  CovarianceOptions covariance;  ///< the local planes

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Prepares clouds. Keeps its memory between clouds, as `out` does.
class CloudPreparer {
 public:
  /// `options.invalid()` must be empty.
  void prepare(const geometry::PointsView& points, const PrepareOptions& options,
               PreparedCloud& out);

 private:
  VoxelDownsampler downsampler_;
  std::vector<NeighbourSearch::Point> candidates_;
};

/// The same as a new cloud.
PreparedCloud prepare_cloud(const geometry::PointsView& points, const PrepareOptions& options = {});

/// Settings of the registration.
struct GicpOptions {
  double max_correspondence_distance = 1;  ///< m; points without a counterpart so near do not count
  PairNoise noise;
  int max_iterations = 50;
  double rotation_tolerance = 1.7e-3;   ///< rad; a step smaller than both tolerances is the last
  double translation_tolerance = 1e-3;  ///< m
  size_t min_inliers = 50;              ///< fewer give no pose
  double min_inlier_fraction = 0.1;  ///< of the source's points; fewer: the clouds do not overlap
  double min_plane_fraction = 0.01;  ///< a direction is free if less of the points' (squared)
                                     ///< displacement by it is along the planes' normals

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Generalized ICP, P 4.2.2 (Segal, Haehnel, Thrun 2009), by Gauss–Newton on SE(3). Does not
/// allocate once it has seen a source of that size. Same bytes on every processor.
class Gicp {
 public:
  /// `options.invalid()` must be empty.
  explicit Gicp(const GicpOptions& options = {});

  /// Finds the source's pose in the target's frame near the guess. Quick where neighbours stand
  /// together in `source`, as in the cloud of a `PreparedCloud`; in any order it takes many times
  /// as long.
  RegistrationResult align(const PreparedCloud& target, const PointCloud& source,
                           const Eigen::Isometry3d& T_target_source_guess);

 private:
  void transform(const PointCloud& source, const Eigen::Isometry3d& T_target_source);
  void search(const PreparedCloud& target, size_t begin, float margin);
  size_t find_pairs(const PreparedCloud& target, double last_move);

  GicpOptions options_;
  Pairs pairs_;
  // Where each point was when its nearest neighbour was last sought, and how far it may move until
  // another one can be nearer.
  Pairs::Field searched_x_, searched_y_, searched_z_, slack_;
  std::vector<int32_t> index_;
  std::vector<geometry::Vector6> cluster_gradients_;
};

/// The same, once.
RegistrationResult gicp(const PreparedCloud& target, const PointCloud& source,
                        const Eigen::Isometry3d& T_target_source_guess,
                        const GicpOptions& options = {});

}  // namespace infuse::registration
