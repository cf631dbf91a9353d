#include "fusion/registration/range_image.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::registration {
namespace {

constexpr int kCells = 60;  // along a side of a face: 1.5° in the middle

/// Cell of a direction: face, row and column.
struct Cell {
  int face, row, column;
};

Cell cell_of(const Eigen::Vector3f& p) {
  int axis = 0;
  const float length = p.cwiseAbs().maxCoeff(&axis);
  const int other = (axis + 1) % 3, last = (axis + 2) % 3;
  const auto index = [&](float value) {
    const float place = (value / length + 1) * (kCells / 2.0F);
    return std::clamp(static_cast<int>(place), 0, kCells - 1);
  };
  return {2 * axis + (p[axis] < 0 ? 1 : 0), index(p[other]), index(p[last])};
}

size_t at(const Cell& cell) {
  return static_cast<size_t>((cell.face * kCells + cell.row) * kCells + cell.column);
}

}  // namespace

RangeImage::RangeImage(const geometry::PointsView& scan)
    : nearest_(size_t{6} * kCells * kCells, 0) {
  for (size_t i = 0; i < scan.x.size(); ++i) {
    const Eigen::Vector3f p(scan.x[i], scan.y[i], scan.z[i]);
    const float range = p.norm();
    if (!(range > 0) || !std::isfinite(range)) continue;
    const Cell middle = cell_of(p);
    for (int row = std::max(0, middle.row - 1); row <= std::min(kCells - 1, middle.row + 1);
         ++row) {
      for (int column = std::max(0, middle.column - 1);
           column <= std::min(kCells - 1, middle.column + 1); ++column) {
        float& nearest = nearest_[at({middle.face, row, column})];
        if (nearest == 0 || range < nearest) nearest = range;
      }
    }
  }
}

float RangeImage::range_towards(const Eigen::Vector3f& direction) const {
  return nearest_[at(cell_of(direction))];
}

}  // namespace infuse::registration
