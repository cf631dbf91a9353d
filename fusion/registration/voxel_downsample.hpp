#pragma once

#include <cstdint>
#include <vector>

#include "fusion/registration/point_cloud.hpp"

namespace infuse::registration {

/// Point that stands for a voxel.
enum class VoxelPoint {
  kMean,   ///< mean of its points
  kFirst,  ///< the first of its points
};

/// Downsamples clouds to one point per occupied voxel. Keeps its memory between clouds.
class VoxelDownsampler {
 public:
  /// Writes one point for every occupied voxel of `voxel_size` (m, > 0), in the order in which the
  /// voxels first occur, without normals (0). Points that are not finite, or more than
  /// a million voxels from the origin, are left out. Does not allocate for clouds that are no
  /// larger than earlier ones.
  void compute(const geometry::PointsView& points, double voxel_size, PointCloud& out,
               VoxelPoint which = VoxelPoint::kMean);

 private:
  struct Cell {
    uint64_t key;
    float x, y, z;  // sum of the points, relative to the voxel's centre
    float count;
  };
  std::vector<Cell> cells_;
  std::vector<uint32_t> slots_;  // hash table: index in cells_ plus 1; 0: empty
};

/// The same as a new cloud.
PointCloud voxel_downsample(const geometry::PointsView& points, double voxel_size);

}  // namespace infuse::registration
