#pragma once

#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::places {

/// Settings of the alignment of outlines (decision 17).
struct OutlineOptions {
  double cell = 0.5;        ///< m
  double range = 45;        ///< m of the points
  double max_shift = 8;     ///< m, along and across
  double max_turn = 0.12;   ///< rad from the guess …
  double turn_step = 0.04;  ///< … in such steps
  double min_height = 0.7;  ///< m above the ground: the ground fits anywhere
  double max_height = 5;    ///< m
};

/// Pose of `source` in the frame of `target` that brings most of what stands on the ground there
/// onto what stands here, seen from above: an exhaustive search of shifts about a guess of the
/// heading. Points in the frames of upright vehicles, m. The height is 0.
Eigen::Isometry3d align_outlines(const geometry::PointsView& target,
                                 const Eigen::Isometry3d& T_target_lidar,
                                 const geometry::PointsView& source,
                                 const Eigen::Isometry3d& T_source_lidar, double yaw_guess,
                                 const OutlineOptions& options = {});

}  // namespace infuse::places
