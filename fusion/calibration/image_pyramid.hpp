#pragma once

#include <map>
#include <span>
#include <vector>

#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// Image features of the scenes at every blur that a search uses, each computed once.
class ImagePyramid {
 public:
  /// Scenes and cameras must outlive this. `blurs` are computed at once, scene by scene, or taken
  /// from the scenes that are prepared (`compact_scene`).
  ImagePyramid(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
               std::span<const TermOptions> terms, std::span<const ImageBlur> blurs);

  /// Returns the blurred features; computes them where the blur is new.
  const BlurredImages& at(const ImageBlur& blur);

 private:
  std::span<const Scene> scenes_;
  std::span<const RigCamera> cameras_;
  std::vector<TermOptions> terms_;
  std::map<ImageBlur, BlurredImages> images_;
};

}  // namespace infuse::calibration
