#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/street_plan.hpp"

namespace infuse::streetmap::bench {

/// Streets between crossings that are about 100 m apart, none of them where a grid would have it: a
/// town of any size.
class IrregularTown {
 public:
  /// `area`: m².
  IrregularTown(double area, uint64_t seed);

  StreetPlan plan() const;

  /// Drives along streets for `length` (m) and returns the poses, every `step` m; at a crossing
  /// half of the time it turns.
  std::vector<PlanarPose> drive(double length, double step, uint64_t seed) const;

 private:
  struct Crossing {
    Eigen::Vector2d at;                // m
    bool east = false, north = false;  // a street leads to the next
  };
  std::vector<int> next_to(int crossing) const;

  int edge_ = 0;  // crossings along it
  std::vector<Crossing> crossings_;
};

}  // namespace infuse::streetmap::bench
