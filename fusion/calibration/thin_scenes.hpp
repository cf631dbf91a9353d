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
/// The points come by strips of the picture, from its top to its bottom.
std::vector<Scene> thin_scenes(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                               const Eigen::Isometry3d& T_head_lidar, double margin, size_t points);

}  // namespace infuse::calibration
