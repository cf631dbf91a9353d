#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace infuse {

/// Arc tangent of y / x in the quadrant of (x, y), rad, as `std::atan2` within 3e-8 rad. Several
/// times as fast in a loop, and the same bits on every processor (Abramowitz and Stegun, 4.4.49).
inline double fast_atan2(double y, double x) {
  const double long_side = std::max(std::abs(x), std::abs(y));
  const double short_side = std::min(std::abs(x), std::abs(y));
  const double t = short_side / (long_side > 0 ? long_side : 1);
  const double s = t * t;
  double series = -0.0161657367 + s * 0.0028662257;
  series = 0.0429096138 + s * series;
  series = -0.0752896400 + s * series;
  series = 0.1065626393 + s * series;
  series = -0.1420889944 + s * series;
  series = 0.1999355085 + s * series;
  series = -0.3333314528 + s * series;
  double angle = t + t * s * series;
  angle = std::abs(y) > std::abs(x) ? std::numbers::pi / 2 - angle : angle;
  angle = x < 0 ? std::numbers::pi - angle : angle;
  return y < 0 ? -angle : angle;
}

}  // namespace infuse
