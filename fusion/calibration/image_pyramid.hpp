#pragma once

#include <map>
#include <span>
#include <vector>

#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// Image features of the scenes at every blur that a search uses, each computed once.
class ImagePyramid {
 public:
  /// Scenes must outlive this. `sigmas` (pixels) are computed at once, scene by scene, or taken
  /// from the scenes that are prepared (`compact_scene`).
  ImagePyramid(std::span<const Scene> scenes, std::span<const TermOptions> terms,
               std::span<const double> sigmas);

  /// Returns the features blurred by `sigma` pixels; computes them where that is new.
  const BlurredImages& at(double sigma);

 private:
  std::span<const Scene> scenes_;
  std::vector<TermOptions> terms_;
  std::map<double, BlurredImages> images_;
};

}  // namespace infuse::calibration
