#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/registration/covariance.hpp"
#include "fusion/registration/voxel_downsample.hpp"

namespace infuse::registration {

/// A cloud that is prepared for registration: downsampled, with its local planes and its tree.
struct PreparedCloud {
  PointCloud cloud;        ///< points and planes
  NeighbourSearch search;  ///< the tree
};

/// Builds the search of a cloud, whose points it puts into the order of the leaves, so that points
/// that are near each other stand together; without normals (0).
void build_and_sort(PointCloud& cloud, NeighbourSearch& search);

/// Settings of the preparation.
struct PrepareOptions {
  double voxel_size = kMapVoxelSize;  ///< m; 0: keep every point that is finite
  CovarianceOptions covariance;       ///< the local planes

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Of points that a lidar at the origin measured.
PrepareOptions sweep_options(double voxel_size = PrepareOptions().voxel_size);

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

}  // namespace infuse::registration
