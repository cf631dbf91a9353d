#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/thin_scenes.hpp"

namespace infuse::calibration {

/// Compares poses that do not share their view: n times the measure, over the n points in view at
/// each. For mutual information that is the logarithm of a likelihood ratio, of which the plug-in
/// estimate's bias is a constant whatever n is: neither few points nor many are of advantage.
///
/// Over wide turns that is not enough. Streets are alike: sky above, road below. Turned down by
/// 20°, a lidar's rings fall in with a picture's rows better than at the true pose, and so they do
/// with every other picture. `subtract_others` takes off what the scans share with pictures of
/// other scenes at the same pose, where each camera has at least `kMinImages`.
class PoseScore {
 public:
  static constexpr size_t kMinImages = 4;

  /// The points are those of `thin` (`thin_scenes`), the images those of `images` at `sigma`
  /// pixels. All must outlive this.
  PoseScore(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
            std::span<const TermOptions> terms, const VisibilityOptions& visibility,
            ImagePyramid& images, double sigma, bool subtract_baseline, std::stop_token stop);

  /// Larger is better; 0 where no point is in view, and at once where a stop was requested.
  double operator()(const Eigen::Isometry3d& T_head_lidar);

  /// Evaluations of the measure so far.
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
