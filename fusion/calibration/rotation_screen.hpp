#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace infuse::calibration {

/// Settings of the screening of rotations.
struct ScreenOptions {
  double half_width = 0.06;  ///< rad about each camera axis; 0: the initial pose alone
  double spacing = 0.02;     ///< rad, spacing of the scored poses in the end
  int max_poses = 800;  ///< maximum number of poses of the first round; wider spacings are refined
  int survivors = 5;    ///< number of best poses that are returned, beside the initial one

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Rotates the initial pose about the camera's own centre by angles spread evenly over ±
/// half_width, scores each, and returns the initial pose and the best, no two within half a
/// spacing. If `max_poses` do not suffice for `spacing`, a second round refines around the best of
/// the first.
std::vector<Eigen::Isometry3d> screen_rotations(
    const Eigen::Isometry3d& initial_pose, const ScreenOptions& options,
    const std::function<double(const Eigen::Isometry3d&)>& score);

}  // namespace infuse::calibration
