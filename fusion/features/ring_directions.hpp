#pragma once

#include <vector>

#include "fusion/geometry/camera_model.hpp"

namespace infuse::features {

/// Directions of the lidar's rings in an image: at a sample, the direction in which a far point
/// moves when it is rotated about the lidar's z axis, as beams are. One unit vector per cell of
/// `kCellSize` × `kCellSize` samples; (0, 0) where no ring can be, because the camera's model sees
/// nothing there or the pixel lies on that axis. Without cells: along the image's rows.
struct RingDirections {
  static constexpr int kCellSize = 16;  ///< samples a side
  int columns = 0, rows = 0;            ///< number of cells
  std::vector<float> right, down;       ///< a value a cell, rows of cells from the top
};

/// Fills in the directions for images reduced by `step` pixels a sample; keeps the memory of
/// `rings`. An approximate pose is enough: an edge at an angle of 10° to a ring loses 2 % of its
/// strength.
void find_ring_directions(const geometry::CameraModel& camera,
                          const Eigen::Isometry3d& T_camera_lidar, int step, RingDirections& rings);

/// The same as a new object, for images that are not reduced.
RingDirections ring_directions(const geometry::CameraModel& camera,
                               const Eigen::Isometry3d& T_camera_lidar);

}  // namespace infuse::features
