#include "daemon/drawing/view_from_above.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "daemon/drawing/label.hpp"

namespace infuse::daemon {
namespace {

constexpr int kViewSize = 800;  // pixels of each view
constexpr int kMargin = 8;      // pixels between them
constexpr auto kMaxDistance = static_cast<float>(kSweepViewMetres);
constexpr float kMinHeight = -1;                          // m, lidar frame: below is ground
constexpr float kScale = kViewSize / (2 * kMaxDistance);  // pixels per m
constexpr int kRingStep = 10, kLastRing = 40;             // m
constexpr Colour kRingColour{56, 52, 48}, kTextColour{210, 205, 200};

void set_pixel(CameraFrame& image, int column, int row, const Colour& colour) {
  uint8_t* pixel = image.pixels.data() + static_cast<size_t>(row) * image.row_bytes() +
                   static_cast<size_t>(column) * 3;
  std::copy(colour.begin(), colour.end(), pixel);
}

}  // namespace

TwoViewsFromAbove::TwoViewsFromAbove(std::array<const char*, 2> titles,
                                     std::vector<ColourMeaning> legend)
    : titles_(titles), legend_(std::move(legend)) {
  image_.width = 2 * kViewSize + kMargin;
  image_.height = kViewSize;
  image_.format = PixelFormat::kBgr8;
  image_.pixels.assign(image_.row_bytes() * kViewSize, 16);
  for (int row = 0; row < kViewSize; ++row) {
    for (int column = 0; column < kMargin; ++column) {
      set_pixel(image_, kViewSize + column, row, {255, 255, 255});
    }
  }
  for (const int view : {0, 1}) draw_rings(view);
}

void TwoViewsFromAbove::draw(int view, float x, float y, float z, const Colour& colour) {
  // Written so that NaN is outside.
  if (!(std::abs(x) < kMaxDistance && std::abs(y) < kMaxDistance && z > kMinHeight)) return;
  const int column = std::min(kViewSize - 1, static_cast<int>((kMaxDistance - y) * kScale));
  const int row = std::min(kViewSize - 1, static_cast<int>((kMaxDistance - x) * kScale));
  set_pixel(image_, view * (kViewSize + kMargin) + column, row, colour);
}

void TwoViewsFromAbove::draw_rings(int view) {
  constexpr double kTurn = 2 * std::numbers::pi;
  for (int radius = kRingStep; radius <= kLastRing; radius += kRingStep) {
    const double step = 1 / (radius * static_cast<double>(kScale));  // a pixel
    for (double angle = 0; angle < kTurn; angle += step) {
      draw(view, static_cast<float>(radius * std::cos(angle)),
           static_cast<float>(radius * std::sin(angle)), 0, kRingColour);
    }
  }
}

void TwoViewsFromAbove::write_labels(int view) {
  const int left = view * (kViewSize + kMargin) + kMargin;
  draw_label(image_, left, kMargin, titles_[static_cast<size_t>(view)], kTextColour);
  int top = kViewSize - kMargin - static_cast<int>(legend_.size()) * label_height();
  for (const ColourMeaning& meaning : legend_) {
    draw_label(image_, left, top, meaning.name, meaning.colour);
    top += label_height();
  }
  const int middle = view * (kViewSize + kMargin) + kViewSize / 2;
  for (int radius = kRingStep; radius < kLastRing; radius += kRingStep) {
    const int row = kViewSize / 2 - static_cast<int>(static_cast<float>(radius) * kScale);
    draw_label(image_, middle + 3, row - label_height(), std::to_string(radius) + " m",
               kTextColour);
  }
}

CameraFrame TwoViewsFromAbove::take() {
  for (const int view : {0, 1}) write_labels(view);
  return std::move(image_);
}

}  // namespace infuse::daemon
