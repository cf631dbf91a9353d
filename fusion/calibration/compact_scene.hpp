#pragma once

#include <optional>
#include <vector>

#include "fusion/calibration/dependence_term.hpp"
#include "fusion/calibration/image_blur.hpp"
#include "fusion/calibration/scene.hpp"

namespace infuse::calibration {

/// Which part of a scene a calibration will use.
struct CompactOptions {
  PerImageFeature<bool> image{};  ///< features that are compared
  std::vector<ImageBlur> blurs;   ///< every one that is looked up
  /// Points stay that can come into view when the camera rotates by so much, rad; nothing: all.
  std::optional<double> margin;
};

/// Prepares a scene: blurs its image features for all `blurs` at once, computes its signature and
/// releases its image and the points that cannot come into view. A fifth of the memory remains.
/// A calibration that uses no more than this has the same result, but for rounding of the image's
/// features to 8 bits.
void compact_scene(Scene& scene, const RigCamera& camera, const Eigen::Isometry3d& T_refcam_lidar,
                   const CompactOptions& options);

}  // namespace infuse::calibration
