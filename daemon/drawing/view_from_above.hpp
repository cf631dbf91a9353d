#pragma once

#include "daemon/drawing/colour_scale.hpp"
#include "drivers/measurement/camera_frame.hpp"

namespace infuse::daemon {

/// Half the edge of each view from above, m.
inline constexpr double kSweepViewMetres = 40;

/// Two views from above beside each other, 40 m to each side of the sensor, x up, without the
/// ground.
class TwoViewsFromAbove {
 public:
  TwoViewsFromAbove();

  /// Draws a point (m, lidar frame) in the left (0) or right (1) view. Points that are not finite
  /// or outside of the view are left out.
  void draw(int view, float x, float y, float z, const Colour& colour);

  CameraFrame take() { return std::move(image_); }

 private:
  CameraFrame image_;
};

}  // namespace infuse::daemon
