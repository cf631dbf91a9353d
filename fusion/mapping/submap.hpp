#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "fusion/geometry/project_points.hpp"
#include "fusion/registration/lengths.hpp"
#include "fusion/registration/point_cloud.hpp"

namespace infuse::mapping {

/// Settings of the clouds of a map.
struct SubmapOptions {
  double voxel_size = registration::kMapVoxelSize;  ///< m, one point per voxel
  double min_range = registration::kMinRange;       ///< m; nearer returns are the vehicle's own
  double max_range = registration::kMaxRange;       ///< m

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Points of the sweeps about a keyframe, in the lidar frame of the keyframe. Coordinates are
/// multiples of `kSubmapStep`.
struct Submap {
  FieldVector<float> x, y, z;       ///< m
  FieldVector<float> reflectivity;  ///< 0 … 1, multiples of 1/255

  size_t size() const { return x.size(); }
  geometry::PointsView points() const { return {x, y, z}; }
  void resize(size_t points);
};

/// m; exact in single precision.
inline constexpr double kSubmapStep = 1.0 / 256;

/// Accumulates deskewed sweeps to a submap: the mean of every voxel.
class SubmapBuilder {
 public:
  /// `options.invalid()` must be empty.
  explicit SubmapBuilder(const SubmapOptions& options) : options_(options) {}

  /// Adds a sweep (lidar frame, m) at its pose in the submap's frame.
  void add(const geometry::PointsView& points, std::span<const float> reflectivity,
           const Eigen::Isometry3d& T_submap_lidar);

  /// The points so far, ordered by voxel; begins anew.
  Submap take();

 private:
  struct Cell {
    uint64_t key;
    Eigen::Vector3d sum;
    double reflectivity, count;
  };
  SubmapOptions options_;
  std::vector<Cell> cells_;
  std::unordered_map<uint64_t, size_t> cell_of_;
  FieldVector<float> x_, y_, z_;
};

}  // namespace infuse::mapping
