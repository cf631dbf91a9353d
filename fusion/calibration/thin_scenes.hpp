#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/visible_points.hpp"

namespace infuse::calibration {

/// Returns the scenes with those points that can come into view when the cameras rotate by up to
/// `margin` radians from `T_refcam_lidar`, thinned evenly so that about `points` of all scenes
/// together are in view at a time, and without images. For searches that compare poses with
/// different points in view, and so need a set of points that belongs to none of them.
///
/// Points near depth edges are few and are the only ones that an edge term compares: they are four
/// times as likely to be kept, or, with `keep_edges`, all kept, and `points` counts the others.
/// `weights`: shares of the scenes' points that are considered, evenly, one each; empty: all.
/// Points are ordered by strips of the image, from its top to its bottom.
std::vector<Scene> thin_scenes(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                               const Eigen::Isometry3d& T_refcam_lidar, double margin,
                               size_t points, bool keep_edges = false,
                               const Eigen::VectorXd& weights = {});

/// Removes the points that cannot come into view when the camera rotates by up to `margin` radians
/// from `T_refcam_lidar`. `thin_scenes` with at most that margin chooses the same points after it.
void keep_points_near(Scene& scene, const RigCamera& camera,
                      const Eigen::Isometry3d& T_refcam_lidar, double margin);

}  // namespace infuse::calibration
