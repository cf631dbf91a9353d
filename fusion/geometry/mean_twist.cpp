#include "fusion/geometry/mean_twist.hpp"

namespace infuse::geometry {

std::optional<Vector6> mean_twist(const Trajectory& trajectory, Stamp from, Stamp to) {
  const MotionBetween moved = trajectory.between(from, to);
  if (!moved.usable()) return std::nullopt;
  return log(moved.T_from_to) / to_seconds(to - from);
}

}  // namespace infuse::geometry
