#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/visible_points.hpp"

namespace infuse::calibration {

/// The points that can come into a picture when the cameras are turned by up to `margin` radians
/// from `T_head_lidar`, thinned evenly so that about `points` of all scenes together lie in the
/// pictures at a time. Without images: those are asked of the scenes themselves. For searches that
/// compare poses which do not share their view, and so need a set of points that belongs to none.
/// Depth edges are few, and their term is asked about them and their surroundings alone: such
/// points are four times as likely to stay; or all of them do, and `points` is of the others. The
/// points come by strips of the picture, from its top to its bottom.
std::vector<Scene> thin_scenes(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                               const Eigen::Isometry3d& T_head_lidar, double margin, size_t points,
                               bool keep_edges = false);

}  // namespace infuse::calibration
