#pragma once

#include <cstdint>
#include <vector>

#include "drivers/measurement/rig.hpp"
#include "fusion/geometry/project_points.hpp"

namespace infuse::registration {

/// The returns of a sweep that a camera sees, by pixel.
class VisibleReturns {
 public:
  VisibleReturns(const geometry::PointsView& points, const CameraMount& camera);

  /// Index of the return whose projection is nearest to the pixel, or -1 if there is none within
  /// `radius` (pixels, at most 8) that is not hidden behind others.
  int32_t nearest(double u, double v, double radius) const;

  /// The return seen in a pixel, or -1.
  int32_t at(int column, int row) const;

 private:
  int width_, height_;
  std::vector<float> u_, v_;      // pixels, one per return
  std::vector<int32_t> returns_;  // of each pixel the nearest to the camera; -1: none
};

}  // namespace infuse::registration
