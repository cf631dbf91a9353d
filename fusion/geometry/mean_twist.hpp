#pragma once

#include <optional>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/geometry/trajectory.hpp"

namespace infuse::geometry {

/// Mean twist of the vehicle from one time to a later one, in its own frame, rad/s and m/s; nothing
/// where the trajectory does not cover them. `adjoint(T_lidar_vehicle)` times it is that of a
/// lidar.
std::optional<Vector6> mean_twist(const Trajectory& trajectory, Stamp from, Stamp to);

}  // namespace infuse::geometry
