#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "fusion/registration/voxel_key.hpp"

namespace infuse::mapping {

/// Positions by the cells of a level grid: what is near is found without comparing all.
class PositionGrid {
 public:
  /// `cell` is the side of a cell, m; look-ups are quickest at radii of that order.
  explicit PositionGrid(double cell) : cell_(cell) {}

  void add(size_t index, const Eigen::Vector3d& position) {
    indices_of_[key_of(cell_at(position.x()), cell_at(position.y()))].push_back(index);
  }

  /// Calls use(index) for all positions within `radius` (m, level) of one, and for some beyond.
  template <class Use>
  void for_each_near(const Eigen::Vector3d& position, double radius, Use use) const {
    const int32_t last_x = cell_at(position.x() + radius), last_y = cell_at(position.y() + radius);
    for (int32_t x = cell_at(position.x() - radius); x <= last_x; ++x) {
      for (int32_t y = cell_at(position.y() - radius); y <= last_y; ++y) {
        const auto found = indices_of_.find(key_of(x, y));
        if (found == indices_of_.end()) continue;
        for (const size_t index : found->second) use(index);
      }
    }
  }

 private:
  /// What is farther away than keys hold, or is no number, counts as at the edge.
  int32_t cell_at(double coordinate) const {
    constexpr double kEdge = registration::kVoxelOffset - 2;
    return registration::floor_to_int(std::max(-kEdge, std::min(kEdge, coordinate / cell_)));
  }
  static uint64_t key_of(int32_t x, int32_t y) { return registration::voxel_key(x, y, 0); }

  double cell_;
  std::unordered_map<uint64_t, std::vector<size_t>> indices_of_;
};

}  // namespace infuse::mapping
