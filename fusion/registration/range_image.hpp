#pragma once

#include <Eigen/Core>
#include <vector>

#include "fusion/geometry/project_points.hpp"

namespace infuse::registration {

/// Ranges of a scan about its sensor, on the six faces of a cube, in cells of 1.5°. Tells what is
/// empty: a beam that passed through a place has found nothing there.
class RangeImage {
 public:
  /// The origin of the points is the sensor. Points that are not finite are left out.
  explicit RangeImage(const geometry::PointsView& scan);

  /// m, range of the nearest point in and around the cell of a direction; 0 if there is none.
  float range_towards(const Eigen::Vector3f& direction) const;

 private:
  std::vector<float> nearest_;
};

}  // namespace infuse::registration
