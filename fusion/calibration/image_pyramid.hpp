#pragma once

#include <map>
#include <span>
#include <vector>

#include "fusion/calibration/objective.hpp"

namespace infuse::calibration {

/// The scenes' image features at every blur that a search asks for, each made once.
class ImagePyramid {
 public:
  /// Scenes must outlive this. `sigmas` (pixels) are made at once, each from the next finer one.
  ImagePyramid(std::span<const Scene> scenes, std::span<const TermOptions> terms,
               std::span<const double> sigmas);

  /// Blurred by `sigma` pixels.
  const BlurredImages& at(double sigma);

 private:
  std::span<const Scene> scenes_;
  std::vector<TermOptions> terms_;
  std::map<double, BlurredImages> images_;
};

}  // namespace infuse::calibration
