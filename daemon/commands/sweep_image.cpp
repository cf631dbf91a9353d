#include "daemon/commands/sweep_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace infuse::daemon {
namespace {

constexpr int kViewSize = 800;      // pixels of each view
constexpr int kMargin = 8;          // pixels between them
constexpr float kMaxDistance = 40;  // m to each side
constexpr float kMinHeight = -1;    // m, lidar frame: below is ground

using Colour = std::array<uint8_t, 3>;  // blue, green, red

void set_pixel(CameraFrame& image, int column, int row, const Colour& colour) {
  uint8_t* pixel = image.pixels.data() + static_cast<size_t>(row) * image.row_bytes() +
                   static_cast<size_t>(column) * 3;
  std::copy(colour.begin(), colour.end(), pixel);
}

/// Colour from blue over green to red.
Colour colour_of(float fraction) {
  const auto bump = [fraction](float centre) {
    const float value = std::clamp(1.5F - 3 * std::abs(fraction - centre), 0.0F, 1.0F);
    return static_cast<uint8_t>(60 + std::lround(195 * value));
  };
  return {bump(0), bump(0.5F), bump(1)};
}

void draw_view(CameraFrame& image, int left, const Sweep& sweep, const FieldVector<float>& x,
               const FieldVector<float>& y, const FieldVector<float>& z) {
  const float span = std::max(1.0F, static_cast<float>(sweep.span.count()));
  constexpr float kScale = kViewSize / (2 * kMaxDistance);
  for (size_t i = 0; i < x.size(); ++i) {
    // Written so that NaN is outside.
    if (!(std::abs(x[i]) < kMaxDistance && std::abs(y[i]) < kMaxDistance && z[i] > kMinHeight))
      continue;
    const int column = std::min(kViewSize - 1, static_cast<int>((kMaxDistance - y[i]) * kScale));
    const int row = std::min(kViewSize - 1, static_cast<int>((kMaxDistance - x[i]) * kScale));
    const float offset = sweep.has_times ? static_cast<float>(sweep.time_offset_ns[i]) : 0;
    set_pixel(image, left + column, row, colour_of(offset / span));
  }
}

}  // namespace

CameraFrame draw_sweep(const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
  CameraFrame image;
  image.width = 2 * kViewSize + kMargin;
  image.height = kViewSize;
  image.format = PixelFormat::kBgr8;
  image.pixels.assign(image.row_bytes() * kViewSize, 16);
  for (int row = 0; row < kViewSize; ++row) {
    for (int column = 0; column < kMargin; ++column) {
      set_pixel(image, kViewSize + column, row, {255, 255, 255});
    }
  }
  draw_view(image, 0, sweep, sweep.x, sweep.y, sweep.z);
  draw_view(image, kViewSize + kMargin, sweep, deskewed.x, deskewed.y, deskewed.z);
  return image;
}

}  // namespace infuse::daemon
