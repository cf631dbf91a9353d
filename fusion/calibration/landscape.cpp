#include "fusion/calibration/landscape.hpp"

namespace infuse::calibration {

Landscape sample_landscape(Objective& fine, Objective& few, const Eigen::Isometry3d& T_refcam_lidar,
                           double rotation, double translation) {
  Landscape out{.rotation = rotation, .translation = translation};
  // `part` of the half width along an axis, −1 … 1.
  const auto step = [&](int axis, double part) -> geometry::Vector6 {
    return part * (axis < 3 ? rotation : translation) * geometry::Vector6::Unit(axis);
  };
  const auto part_of = [](int k, int count) { return 2.0 * k / (count - 1) - 1; };
  const auto value = [&](Objective& measure, const geometry::Vector6& xi) {
    return measure.evaluate(geometry::exp(xi) * T_refcam_lidar, false).estimate.value;
  };
  for (int axis = 0; axis < 6; ++axis) {
    for (int k = 0; k < Landscape::kSamplesPerAxis; ++k) {
      out.axis_profiles[static_cast<size_t>(axis)][static_cast<size_t>(k)] =
          value(fine, step(axis, part_of(k, Landscape::kSamplesPerAxis)));
    }
  }
  for (int first = 0; first < 6; ++first) {
    for (int second = first + 1; second < 6; ++second) {
      Landscape::Map map{.first = first, .second = second};
      for (int row = 0; row < Landscape::kMapSize; ++row) {
        for (int column = 0; column < Landscape::kMapSize; ++column) {
          map.values[static_cast<size_t>(row * Landscape::kMapSize + column)] =
              value(few, step(first, part_of(column, Landscape::kMapSize)) +
                             step(second, part_of(row, Landscape::kMapSize)));
        }
      }
      out.maps.push_back(map);
    }
  }
  return out;
}

}  // namespace infuse::calibration
