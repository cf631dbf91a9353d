#include "fusion/places/small_image.hpp"

#include <algorithm>

namespace infuse::places {

std::vector<uint8_t> shrink_image(const CameraFrame& frame, int width, int height) {
  std::vector<uint8_t> out;
  out.reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
  const auto begin_of = [](int cell, int cells, int pixels) {
    return static_cast<int>(int64_t{cell} * pixels / cells);
  };
  for (int row = 0; row < height; ++row) {
    const int top = begin_of(row, height, frame.height);
    const int bottom = std::max(begin_of(row + 1, height, frame.height), top + 1);
    for (int column = 0; column < width; ++column) {
      const int left = begin_of(column, width, frame.width);
      const int right = std::max(begin_of(column + 1, width, frame.width), left + 1);
      int64_t sum = 0;
      for (int y = top; y < bottom; ++y) {
        const uint8_t* pixels = &frame.pixels[static_cast<size_t>(y) * frame.row_bytes()];
        for (int x = left; x < right; ++x) sum += pixels[x];
      }
      const int64_t count = int64_t{bottom - top} * (right - left);
      out.push_back(static_cast<uint8_t>((sum + count / 2) / count));
    }
  }
  return out;
}

}  // namespace infuse::places
