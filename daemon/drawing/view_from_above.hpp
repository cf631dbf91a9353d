#pragma once

#include <array>
#include <string>
#include <vector>

#include "daemon/drawing/colour_scale.hpp"
#include "drivers/measurement/camera_frame.hpp"

namespace infuse::daemon {

/// Half the edge of each view from above, m.
inline constexpr double kSweepViewMetres = 40;

/// What a colour means.
struct ColourMeaning {
  std::string name;
  Colour colour;
};

/// Two views from above beside each other, 40 m to each side of the sensor, x up, without the
/// ground; with a ring every 10 m, titles and a legend, in the characters of `draw_label`.
class TwoViewsFromAbove {
 public:
  TwoViewsFromAbove(std::array<const char*, 2> titles, std::vector<ColourMeaning> legend);

  /// Draws a point (m, lidar frame) in the left (0) or right (1) view. Points that are not finite
  /// or outside of the view are left out.
  void draw(int view, float x, float y, float z, const Colour& colour);

  /// The image, once.
  CameraFrame take();

 private:
  void draw_rings(int view);
  void write_labels(int view);

  std::array<const char*, 2> titles_;
  std::vector<ColourMeaning> legend_;
  CameraFrame image_;
};

}  // namespace infuse::daemon
