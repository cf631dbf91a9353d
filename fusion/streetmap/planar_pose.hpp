#pragma once

#include <Eigen/Core>
#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::streetmap {

/// An angle within −π … π.
/// A pose in the plane: where the vehicle stands and where it looks, I 3.2.
struct PlanarPose {
  double x = 0;    ///< m
  double y = 0;    ///< m
  double yaw = 0;  ///< rad, counter-clockwise from x

  /// Where a point of the vehicle's frame is.
  Eigen::Vector2d transform(const Eigen::Vector2d& point) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {x + c * point.x() - s * point.y(), y + s * point.x() + c * point.y()};
  }

  /// The pose after a motion that is given in this pose's frame.
  PlanarPose compose(const PlanarPose& motion) const {
    const Eigen::Vector2d place = transform({motion.x, motion.y});
    return {place.x(), place.y(), wrap_angle(yaw + motion.yaw)};
  }

  /// The motion that leads from this pose to another: then(motion_to(p)) is p.
  PlanarPose motion_to(const PlanarPose& other) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const double dx = other.x - x, dy = other.y - y;
    return {c * dx + s * dy, -s * dx + c * dy, wrap_angle(other.yaw - yaw)};
  }

  bool operator==(const PlanarPose&) const = default;
};

}  // namespace infuse::streetmap
