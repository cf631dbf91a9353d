#pragma once

#include <cmath>
#include <numbers>

namespace infuse {

/// One degree, rad: `angle * kDegree` converts degrees to radians, `angle / kDegree` radians to
/// degrees.
inline constexpr double kDegree = std::numbers::pi / 180;

/// Wraps an angle to [−π, π], rad.
inline double wrap_angle(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace infuse
