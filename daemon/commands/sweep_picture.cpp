#include "daemon/commands/sweep_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace infuse::daemon {
namespace {

constexpr int kSide = 800;          // pixels of each view
constexpr int kMargin = 8;          // pixels between them
constexpr float kReach = 40;        // m to each side
constexpr float kLeastHeight = -1;  // m, lidar frame: below is ground

using Colour = std::array<uint8_t, 3>;  // blue, green, red

void paint(CameraFrame& picture, int column, int row, const Colour& colour) {
  uint8_t* pixel = picture.pixels.data() + static_cast<size_t>(row) * picture.row_bytes() +
                   static_cast<size_t>(column) * 3;
  std::copy(colour.begin(), colour.end(), pixel);
}

/// From blue over green to red.
Colour colour_of(float fraction) {
  const auto bump = [fraction](float centre) {
    const float value = std::clamp(1.5F - 3 * std::abs(fraction - centre), 0.0F, 1.0F);
    return static_cast<uint8_t>(60 + std::lround(195 * value));
  };
  return {bump(0), bump(0.5F), bump(1)};
}

void draw_view(CameraFrame& picture, int left, const Sweep& sweep, const Channel<float>& x,
               const Channel<float>& y, const Channel<float>& z) {
  const float span = std::max(1.0F, static_cast<float>(sweep.span.count()));
  constexpr float kScale = kSide / (2 * kReach);
  for (size_t i = 0; i < x.size(); ++i) {
    // What is not a number is not inside.
    if (!(std::abs(x[i]) < kReach && std::abs(y[i]) < kReach && z[i] > kLeastHeight)) continue;
    const int column = std::min(kSide - 1, static_cast<int>((kReach - y[i]) * kScale));
    const int row = std::min(kSide - 1, static_cast<int>((kReach - x[i]) * kScale));
    const float offset = sweep.has_times ? static_cast<float>(sweep.time_offset_ns[i]) : 0;
    paint(picture, left + column, row, colour_of(offset / span));
  }
}

}  // namespace

CameraFrame draw_sweep(const Sweep& sweep, const motion::StraightSweep& straight) {
  CameraFrame picture;
  picture.width = 2 * kSide + kMargin;
  picture.height = kSide;
  picture.format = PixelFormat::kBgr8;
  picture.pixels.assign(picture.row_bytes() * kSide, 16);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kMargin; ++column) {
      paint(picture, kSide + column, row, {255, 255, 255});
    }
  }
  draw_view(picture, 0, sweep, sweep.x, sweep.y, sweep.z);
  draw_view(picture, kSide + kMargin, sweep, straight.x, straight.y, straight.z);
  return picture;
}

}  // namespace infuse::daemon
