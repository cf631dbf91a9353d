#pragma once

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::daemon {

/// The part of a pose that lies in the plane.
streetmap::PlanarPose planar(const Eigen::Isometry3d& T);

/// Predicts the tracker from one time to a later one by the trajectory of the odometry; where that
/// has a gap, the motion is unknown.
void predict(streetmap::Tracker& tracker, const geometry::Trajectory& trajectory, Stamp from,
             Stamp to);

}  // namespace infuse::daemon
