#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace infuse::calibration {

/// Settings of the search for rotations from which a climb is worth its while.
struct ScreenOptions {
  double half_width = 0.06;  ///< rad about each camera axis; 0: the start alone
  double spacing = 0.02;     ///< rad, between the poses that are scored in the end
  int max_poses = 800;       ///< poses of the first round; more are spread wider, then refined
  int survivors = 5;         ///< best poses handed on, beside the start

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Turns `start` (about the camera's own centre) by angles spread evenly over ± half_width, scores
/// each, and gives back the start and the best, no two within half a spacing. Where `most` poses
/// cannot lie `spacing` apart, a second round fills in around the best of the first.
std::vector<Eigen::Isometry3d> screen_rotations(
    const Eigen::Isometry3d& start, const ScreenOptions& options,
    const std::function<double(const Eigen::Isometry3d&)>& score);

}  // namespace infuse::calibration
