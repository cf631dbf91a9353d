#pragma once

#include <array>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"

namespace infuse::streetmap {

/// What a pixel knows, I table 3.2.
struct ImageFeatures {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  /// By pixel: blue, green, red and the root of the Sobel magnitude of the luminance, each 0 … 1;
  /// and the Sobel orientation, −π … π.
  std::vector<std::array<float, 5>> pixels;

  const std::array<float, 5>& at(int x, int y) const {
    return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

/// Colours and gradients of a picture in kBgr8 or kGrey8, reduced by `step` (means of step × step
/// pixels) first. False where the format is another or the picture smaller than that; `features`
/// keeps its memory.
bool extract_features(const CameraFrame& image, int step, ImageFeatures& features);

}  // namespace infuse::streetmap
