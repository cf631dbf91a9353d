#pragma once

#include "fusion/geometry/trajectory.hpp"
#include "fusion/registration/uncertainty.hpp"

namespace infuse::registration {

/// Pose of the lidar that other sensors measured, and the information of its left perturbation in
/// the unit of the sums over points.
struct PosePrior {
  Eigen::Isometry3d T_anchor_lidar;
  geometry::Matrix6 information;
};

/// Prior of a measured motion that begins at T_anchor_from. `scale` is its weight beside the sums
/// over points.
PosePrior anchored_prior(const geometry::MotionBetween& motion,
                         const Eigen::Isometry3d& T_anchor_from,
                         const Eigen::Isometry3d& T_vehicle_lidar, double scale);

/// Gauss–Newton step towards the planes in the directions that they determine, and towards the
/// prior in all.
geometry::Vector6 step_with_prior(const PoseSystem& system, const DeterminedDirections& determined,
                                  const Eigen::Isometry3d& T_anchor_lidar, const PosePrior& prior);

}  // namespace infuse::registration
