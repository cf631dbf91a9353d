#pragma once

#include <array>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"

namespace infuse::streetmap {

/// Features of an image by pixel, I table 3.2.
struct ImageFeatures {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  /// Row by row: blue, green, red and the square root of the Sobel magnitude of the luminance, each
  /// 0 … 1; Sobel orientation, −π … π.
  std::vector<std::array<float, 5>> pixels;

  const std::array<float, 5>& at(int x, int y) const {
    return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

/// Computes colours and gradients of an image in kBgr8 or kGrey8, reduced by `step` first (means of
/// step × step pixels). False if the format is another or the image is smaller than one reduced
/// pixel. `features` keeps its memory.
bool extract_features(const CameraFrame& image, int step, ImageFeatures& features);

}  // namespace infuse::streetmap
