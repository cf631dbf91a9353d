#include "fusion/streetmap/image_features.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

/// Means of step × step pixels, 0 … 1; the rest of the features stays 0.
void reduce(const CameraFrame& image, int step, ImageFeatures& features) {
  const auto channels = static_cast<size_t>(infuse::channels(image.format));
  const float scale = 1.0F / (255.0F * static_cast<float>(step * step));
  for (int y = 0; y < features.height; ++y) {
    for (int x = 0; x < features.width; ++x) {
      int sums[3] = {0, 0, 0};
      for (int dy = 0; dy < step; ++dy) {
        const uint8_t* row = image.pixels.data() +
                             static_cast<size_t>(y * step + dy) * image.row_bytes() +
                             static_cast<size_t>(x * step) * channels;
        for (int dx = 0; dx < step; ++dx, row += channels) {
          for (size_t c = 0; c < 3; ++c) sums[c] += row[channels == 3 ? c : 0];
        }
      }
      auto& pixel = features.pixels[static_cast<size_t>(y) * static_cast<size_t>(features.width) +
                                    static_cast<size_t>(x)];
      pixel = {};
      for (size_t c = 0; c < 3; ++c) pixel[c] = static_cast<float>(sums[c]) * scale;
    }
  }
}

}  // namespace

bool extract_features(const CameraFrame& image, int step, ImageFeatures& features) {
  const bool known = image.format == PixelFormat::kBgr8 || image.format == PixelFormat::kGrey8;
  if (!known || step < 1 || image.width < 3 * step || image.height < 3 * step ||
      image.pixels.size() < image.row_bytes() * static_cast<size_t>(image.height)) {
    return false;
  }
  features.width = image.width / step;
  features.height = image.height / step;
  features.pixels.resize(static_cast<size_t>(features.width) *
                         static_cast<size_t>(features.height));
  reduce(image, step, features);
  const int w = features.width, h = features.height;
  const auto luminance = [&](int x, int y) {
    const auto& p = features.at(std::clamp(x, 0, w - 1), std::clamp(y, 0, h - 1));
    return 0.114F * p[0] + 0.587F * p[1] + 0.299F * p[2];
  };
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const float gx = luminance(x + 1, y - 1) + 2 * luminance(x + 1, y) + luminance(x + 1, y + 1) -
                       luminance(x - 1, y - 1) - 2 * luminance(x - 1, y) - luminance(x - 1, y + 1);
      const float gy = luminance(x - 1, y + 1) + 2 * luminance(x, y + 1) + luminance(x + 1, y + 1) -
                       luminance(x - 1, y - 1) - 2 * luminance(x, y - 1) - luminance(x + 1, y - 1);
      auto& pixel =
          features.pixels[static_cast<size_t>(y) * static_cast<size_t>(w) + static_cast<size_t>(x)];
      pixel[3] = std::sqrt(std::sqrt(gx * gx + gy * gy) / 5.66F);
      pixel[4] = std::atan2(gy, gx);
    }
  }
  return true;
}

}  // namespace infuse::streetmap
