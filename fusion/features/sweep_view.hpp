#pragma once

#include <cstdint>
#include <span>

#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/project_points.hpp"

namespace infuse::features {

/// Returns of a deskewed sweep as spans, one entry a return in each: points in the lidar frame as
/// of one moment, and the quantities that deskewing does not change. Returns of one ring follow
/// each other as they were fired.
struct SweepView {
  geometry::PointsView points;             ///< m
  std::span<const float> range;            ///< m
  std::span<const float> reflectivity;     ///< 0 … 1
  std::span<const uint16_t> ring, column;  ///< as in `Sweep`

  size_t size() const { return range.size(); }  ///< number of returns
};

/// View of a sweep that is deskewed already, or needs no deskewing.
inline SweepView make_sweep_view(const Sweep& sweep) {
  return {{sweep.x, sweep.y, sweep.z}, sweep.range, sweep.reflectivity, sweep.ring, sweep.column};
}

}  // namespace infuse::features
