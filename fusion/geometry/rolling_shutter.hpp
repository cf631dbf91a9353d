#pragma once

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {

/// Moves points to the times at which a rolling shutter exposed the rows that they lie on. A camera
/// that yaws by 20°/s and reads its rows within 30 ms shears the image by 0.6°, as much as a knock.
///
/// A row v of h is exposed dt = `readout` (v / (h − 1) − ½) after the middle one. A point of the
/// surroundings is then at p − dt (ω × p + v), to first order: the rest, (|ω| dt)² |p| / 2, is 1 mm
/// at 0.5 rad/s, 15 ms and 40 m. The row is that of the point before it is moved.
struct RollingShutter {
  const CameraModel& camera;
  Duration readout;  ///< `CameraMount::readout`
  Vector6 twist;     ///< of the lidar in its own frame, rad/s and m/s

  /// `x`, `y`, `z`: points in the lidar frame as of the exposure of the middle row, m. Points that
  /// the camera does not project stay. `pixels`: scratch, as long as the points; receives the
  /// pixels before the move.
  void move(const Eigen::Isometry3d& T_camera_lidar, std::span<float> x, std::span<float> y,
            std::span<float> z, const PixelsView& pixels) const;
};

}  // namespace infuse::geometry
