#pragma once

#include <vector>

#include "fusion/geometry/camera_model.hpp"

namespace infuse::calibration {

/// Which way the lidar's rings run through a picture: at a pixel the direction in which a far point
/// moves when it is turned about the lidar's z axis, as beams are. A unit vector for every square
/// of `kSquare` pixels; (0, 0) where no ring can be, because the camera's model sees nothing there
/// or looks along that axis. Without any square: along the picture's rows.
struct RingDirections {
  static constexpr int kCellSize = 16;  ///< px a side
  int columns = 0, rows = 0;            ///< of squares
  std::vector<float> right, down;       ///< a value a square, rows of squares from the top
};

/// As the camera stands to the lidar. Degrees do not matter: an edge seen at an angle of 10° to a
/// ring has lost 2 % of its strength.
RingDirections ring_directions(const geometry::CameraModel& camera,
                               const Eigen::Isometry3d& T_camera_lidar);

}  // namespace infuse::calibration
