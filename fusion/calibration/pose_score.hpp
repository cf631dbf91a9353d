#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/thin_scenes.hpp"

namespace infuse::calibration {

/// Score for comparing poses with different points in view: n times the measure, over the n points
/// in view at each pose. For mutual information that is the logarithm of a likelihood ratio, and
/// the bias of the plug-in estimate is a constant whatever n is: neither few nor many points have
/// an advantage.
///
/// Over wide rotations that is not enough. Streets are alike: sky above, road below. Rotated down
/// by 20°, the rings of a lidar match the rows of an image better than at the true pose, and so
/// they match every other image. `subtract_baseline` subtracts the score with the images of other
/// scenes at the same pose, if each camera has at least `kMinImages`.
class PoseScore {
 public:
  static constexpr size_t kMinImages = 4;

  /// The points are those of `scenes` (`thin_scenes`), the images those of `images` at `sigma` px,
  /// see `ImageBlur`. All must outlive this.
  PoseScore(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
            std::span<const TermOptions> terms, const VisibilityOptions& visibility,
            ImagePyramid& images, double sigma, bool subtract_baseline, std::stop_token stop);

  /// Returns the score, larger is better; 0 if no point is in view or a stop was requested.
  double operator()(const Eigen::Isometry3d& T_refcam_lidar);

  /// Number of evaluations of the measure so far.
  int evaluations() const { return evaluations_; }

 private:
  std::span<const Scene> scenes_;
  std::span<const RigCamera> cameras_;
  std::span<const TermOptions> terms_;
  VisibilityOptions visibility_;
  const BlurredImages& images_;
  std::optional<BlurredImages> baseline_images_;
  std::stop_token stop_;
  int evaluations_ = 0;
};

}  // namespace infuse::calibration
