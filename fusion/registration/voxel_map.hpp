#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/registration/lengths.hpp"
#include "fusion/registration/pairs.hpp"
#include "fusion/registration/point_cloud.hpp"

namespace infuse::registration {

/// Settings of the local map.
struct VoxelMapOptions {
  double voxel_size = 1;       ///< m, as Vizzo et al. 2023
  double min_spacing = 0.1;    ///< m between the points of a voxel, at most 16 (decision 17)
  double range = kMaxRange;    ///< m; voxels farther from the lidar are dropped
  size_t max_voxels = 65'536;  ///< maximum number of voxels, 256 bytes each; more are not added
  int min_points = kMinPlanePoints;  ///< fewer near a point give no plane
  double min_spread = 0.2;  ///< second variance of a voxel's points over the first; a line or
                            ///< strip below gives no plane (decision 10)

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Points around the lidar in a hash table of voxels, bounded in memory, and planes fitted to them.
/// Positions are kept relative to their voxel, so they are exact however far the vehicle drives.
class VoxelMap {
 public:
  /// `options.invalid()` must be empty. Allocates all memory.
  explicit VoxelMap(const VoxelMapOptions& options = {});

  /// Adds points of a sweep, except where the map is dense enough.
  void insert(const geometry::PointsView& points, const Eigen::Isometry3d& T_map_lidar);

  /// Drops the voxels out of range of a position.
  void drop_far(const Eigen::Vector3d& position);

  void clear();
  bool empty() const { return voxels_.empty(); }
  size_t voxels() const { return voxels_.size(); }

  /// Corner of the voxel that holds a position: origin of the frame in which planes are sought.
  Eigen::Vector3d anchor(const Eigen::Vector3d& position) const;

  /// Fits a plane to the map's points within `radius` (m, at most a voxel) of the pair's point p,
  /// with weights that fall to 0 at the radius. p and the results are relative to `anchor`. Sets
  /// the pair's point q to the foot of p on the plane, the target's normal to the plane's, and the
  /// weight to its planarity, 0 … 1; 0 where there is no plane. Same bytes on every processor.
  void find_planes(const Eigen::Vector3d& anchor, double radius, const std::vector<int32_t>& which,
                   Pairs& pairs) const;

  /// Points of a voxel relative to its corner; unused entries are infinitely far away.
  struct Voxel {
    Floats x, y, z;
    uint64_t key;
    int32_t count;
  };

 private:
  const Voxel* find(uint64_t key) const;
  Voxel* find_or_add(uint64_t key);
  void rebuild_slots();

  VoxelMapOptions options_;
  std::vector<Voxel, UninitializedAllocator<Voxel>> voxels_;
  std::vector<uint32_t> slots_;  // hash table: index in voxels_ plus 1; 0: empty
};

}  // namespace infuse::registration
