#pragma once

#include <Eigen/Core>
#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::streetmap {

/// Pose in the plane: position and heading, I 3.2.
struct PlanarPose {
  double x = 0;    ///< m
  double y = 0;    ///< m
  double yaw = 0;  ///< rad, counter-clockwise from x

  /// Transforms a point of the vehicle frame.
  Eigen::Vector2d transform(const Eigen::Vector2d& point) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {x + c * point.x() - s * point.y(), y + s * point.x() + c * point.y()};
  }

  /// Composes this pose with a motion given in its frame.
  PlanarPose compose(const PlanarPose& motion) const {
    const Eigen::Vector2d place = transform({motion.x, motion.y});
    return {place.x(), place.y(), wrap_angle(yaw + motion.yaw)};
  }

  /// Returns the motion from this pose to another: compose(motion_to(p)) is p.
  PlanarPose motion_to(const PlanarPose& other) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const double dx = other.x - x, dy = other.y - y;
    return {c * dx + s * dy, -s * dx + c * dy, wrap_angle(other.yaw - yaw)};
  }

  bool operator==(const PlanarPose&) const = default;  ///< of all
};

/// The rigid transform that takes `from` to `to`.
inline PlanarPose transform_between(const PlanarPose& from, const PlanarPose& to) {
  return to.compose(from.motion_to({}));
}

}  // namespace infuse::streetmap
