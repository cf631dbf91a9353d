#include "daemon/drawing/view_from_above.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::daemon {
namespace {

constexpr int kViewSize = 800;  // pixels of each view
constexpr int kMargin = 8;      // pixels between them
constexpr auto kMaxDistance = static_cast<float>(kSweepViewMetres);
constexpr float kMinHeight = -1;  // m, lidar frame: below is ground

void set_pixel(CameraFrame& image, int column, int row, const Colour& colour) {
  uint8_t* pixel = image.pixels.data() + static_cast<size_t>(row) * image.row_bytes() +
                   static_cast<size_t>(column) * 3;
  std::copy(colour.begin(), colour.end(), pixel);
}

}  // namespace

TwoViewsFromAbove::TwoViewsFromAbove() {
  image_.width = 2 * kViewSize + kMargin;
  image_.height = kViewSize;
  image_.format = PixelFormat::kBgr8;
  image_.pixels.assign(image_.row_bytes() * kViewSize, 16);
  for (int row = 0; row < kViewSize; ++row) {
    for (int column = 0; column < kMargin; ++column) {
      set_pixel(image_, kViewSize + column, row, {255, 255, 255});
    }
  }
}

void TwoViewsFromAbove::draw(int view, float x, float y, float z, const Colour& colour) {
  // Written so that NaN is outside.
  if (!(std::abs(x) < kMaxDistance && std::abs(y) < kMaxDistance && z > kMinHeight)) return;
  constexpr float kScale = kViewSize / (2 * kMaxDistance);
  const int column = std::min(kViewSize - 1, static_cast<int>((kMaxDistance - y) * kScale));
  const int row = std::min(kViewSize - 1, static_cast<int>((kMaxDistance - x) * kScale));
  set_pixel(image_, view * (kViewSize + kMargin) + column, row, colour);
}

}  // namespace infuse::daemon
