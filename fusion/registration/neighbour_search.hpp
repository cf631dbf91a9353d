#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fusion/registration/lanes.hpp"
#include "fusion/registration/point_cloud.hpp"

namespace infuse::registration {

/// Nearest point of a cloud.
struct Nearest {
  int32_t index = -1;         ///< in the cloud; -1 if there is none within the maximum distance
  float square_distance = 0;  ///< m²
  float others = 0;           ///< m; every other point of the cloud is at least this far away
};

/// Exact nearest neighbours in a cloud: a balanced kd-tree whose leaves of 16 points are compared
/// at once. Same results on every processor.
class NeighbourSearch {
 public:
  static constexpr int kMaxNeighbours = 32;

  /// Builds the tree. Points that are not finite are left out. Does not allocate for clouds that
  /// are no larger than earlier ones.
  void build(const geometry::PointsView& points);

  /// Number of points in the tree.
  size_t size() const { return size_; }

  /// Finds the nearest point within `max_distance` (m). Also bounds the distance of all others from
  /// below, by up to `margin` (m) more than the nearest one's.
  Nearest nearest(const float* point, float max_distance, float margin) const;

  /// Finds the nearest points, `neighbours` (1 … kMaxNeighbours) of them if there are as many, in
  /// order of distance; writes their indices and squared distances (m²) and returns their number.
  int nearest_neighbours(const float* point, int neighbours, int32_t* indices,
                         float* square_distances) const;

  /// A node of the tree: plane between its two children.
  struct Split {
    float value;
    int32_t axis;
  };
  /// Points of a leaf; unused entries are infinitely far away.
  struct Leaf {
    Floats x, y, z;
    int32_t index[kLanes];
  };

 private:
  struct Entry {
    float at[3];
    int32_t index;
  };
  void build_node(size_t node, size_t begin, size_t end);

  size_t size_ = 0;
  std::vector<Entry> entries_;
  std::vector<Split, UninitializedAllocator<Split>> splits_;  // of a complete binary tree
  std::vector<Leaf, UninitializedAllocator<Leaf>> leaves_;    // its lowest row
};

}  // namespace infuse::registration
