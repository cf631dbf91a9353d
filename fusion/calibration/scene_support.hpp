#pragma once

#include <vector>

#include "fusion/calibration/coarse_to_fine.hpp"

namespace infuse::calibration {

/// What a scene by itself says of a calibration; scenes of few points say it together with those
/// that follow.
struct SceneSupport {
  size_t points = 0;  ///< in view, of this scene
  double value = 0;   ///< the measure of this scene alone
  double support = 0;  ///< share of 12 wrong rotations (about each axis by ±1°, ±2°) at which the
                       ///< measure of this scene alone is smaller: 1 speaks for the calibration,
                       ///< what picture and scan of different places give lies about one half
};

/// An entry a scene. Images are blurred by `sigma` pixels.
std::vector<SceneSupport> scene_support(CoarseToFine& search, const Eigen::Isometry3d& T_head_lidar,
                                        size_t scenes, double sigma);

}  // namespace infuse::calibration
