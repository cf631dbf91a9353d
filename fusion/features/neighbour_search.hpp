#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/measurement/sweep.hpp"
#include "fusion/features/lanes.hpp"
#include "fusion/geometry/project_points.hpp"

namespace infuse::features {

/// Nearest point of a cloud.
struct Nearest {
  int32_t index = -1;         ///< in the cloud; -1 if there is none within the maximum distance
  float square_distance = 0;  ///< m²
  float others = 0;           ///< m; every other point of the cloud is at least this far away
};

/// Up to 16 points whose nearest ones are sought side by side.
struct NearestQueries {
  Floats at[3];         ///< m: x, y, z
  Floats max_distance;  ///< m; below 0: not sought
};

/// Results of a batch, lane by lane. Lanes with `max_distance` < 0 are undefined. `index` is -1
/// where nothing was found; `square_distance` is then undefined.
struct NearestOfEach {
  Ints index;
  Floats square_distance;
  Floats others;
};

/// Sums over the nearest neighbours of up to 16 points, side by side; relative to each point.
struct Neighbourhoods {
  /// Number of neighbours; 0 in lanes without a point. Of several equally far last ones, any is
  /// taken.
  Floats count;
  Floats sum[3];    ///< m: x, y, z
  Floats cross[6];  ///< m²: xx, xy, xz, yy, yz, zz
};

/// Exact nearest neighbours in a cloud: a balanced kd-tree whose leaves of 16 points are compared
/// at once. Same results on every processor.
class NeighbourSearch {
 public:
  static constexpr int kMaxNeighbours = 32;  ///< bounds memory on the stack

  /// Builds the tree. Points that are not finite are left out. Does not allocate for clouds that
  /// are no larger than earlier ones.
  void build(const geometry::PointsView& points);

  /// The same, and puts the points into the order of the leaves, so that points that are near each
  /// other stand together.
  void build_and_sort(FieldVector<float>& x, FieldVector<float>& y, FieldVector<float>& z);

  /// Number of points in the tree.
  size_t size() const { return size_; }

  /// Finds the nearest point within `max_distance` (m). Also bounds the distance of all others from
  /// below, by up to `margin` (m) more than the nearest one's.
  Nearest nearest(const float* point, float max_distance, float margin) const;

  /// The same for points that are near each other, which takes a fraction of the time; far apart
  /// they take many times as long.
  NearestOfEach nearest_of_each(const NearestQueries& queries, float margin) const;

  /// Finds the `indices.size()` nearest points (at least 1) whose squared distance is below
  /// `max_square` (m²), the nearest first, and their squared distances. Returns their number.
  size_t nearest_points(const float* point, float max_square, std::span<int32_t> indices,
                        std::span<float> squares) const;

  /// A node of the tree: plane between its two children.
  struct Split {
    float value;
    int32_t axis;
  };
  /// Points of a leaf; unused entries, the last ones, are infinitely far away and have the index
  /// -1.
  struct Leaf {
    Floats x, y, z;
    int32_t index[kLanes];
  };
  std::span<const Leaf> leaves() const { return leaves_; }

  /// Point of the tree.
  struct Point {
    float x, y, z;
  };
  /// Sums over the `neighbours` (1 … kMaxNeighbours) nearest points of each point of a leaf, itself
  /// among them, or over all if there are not as many. `memory` is the caller's: it does not
  /// allocate when it was used for a tree of this size.
  Neighbourhoods neighbourhoods(const Leaf& leaf, int neighbours, std::vector<Point>& memory) const;

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

}  // namespace infuse::features
