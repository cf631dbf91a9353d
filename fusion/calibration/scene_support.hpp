#pragma once

#include <vector>

#include "fusion/calibration/coarse_to_fine.hpp"

namespace infuse::calibration {

/// Support of a calibration by one scene alone; scenes of few points are evaluated together with
/// those that follow.
struct SceneSupport {
  size_t points = 0;  ///< number of points of this scene in view
  double value = 0;   ///< measure of this scene alone
  double support = 0;  ///< share of 12 wrong rotations (about each axis by ±1°, ±2°) at which the
                       ///< measure of this scene alone is smaller: 1 supports the calibration, an
                       ///< image and a scan of different places give about one half
};

/// Computes the support, one entry per scene. Images are blurred by `sigma` px, see `ImageBlur`.
std::vector<SceneSupport> scene_support(CoarseToFine& search,
                                        const Eigen::Isometry3d& T_refcam_lidar, size_t scenes,
                                        double sigma);

}  // namespace infuse::calibration
