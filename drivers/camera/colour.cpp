#include "drivers/camera/colour.hpp"

#include <algorithm>
#include <array>

#include "drivers/measurement/simd.hpp"

namespace infuse::camera {
namespace {

enum Channel : size_t { kBlue = 0, kGreen = 1, kRed = 2 };

/// Colours of the 2 × 2 tile at the top left, by row.
std::array<Channel, 4> bayer_tile(PixelFormat format) {
  switch (format) {
    case PixelFormat::kBayerRggb8:
      return {kRed, kGreen, kGreen, kBlue};
    case PixelFormat::kBayerBggr8:
      return {kBlue, kGreen, kGreen, kRed};
    case PixelFormat::kBayerGbrg8:
      return {kGreen, kBlue, kRed, kGreen};
    default:
      return {kGreen, kRed, kBlue, kGreen};
  }
}

void copy_all_but_pixels(const CameraFrame& from, CameraFrame& to) {
  to.stamp = from.stamp;
  to.exposure = from.exposure;
  to.gain = from.gain;
  to.sequence = from.sequence;
  to.width = from.width;
  to.height = from.height;
  to.format = PixelFormat::kGrey8;
  to.pixels.resize(to.row_bytes() * static_cast<size_t>(to.height));
}

/// Converts `pixels` pixels of blue, green and red.
INFUSE_SIMD_CLONES void to_luminance(const uint8_t* __restrict bgr, size_t pixels,
                                     uint8_t* __restrict grey) {
  for (size_t i = 0; i < pixels; ++i) {
    grey[i] = luminance(bgr[3 * i], bgr[3 * i + 1], bgr[3 * i + 2]);
  }
}

/// Bilinear interpolation: a missing colour is the mean of its nearest samples in the 3 × 3
/// neighbourhood; at the border, of those inside the image.
std::array<uint32_t, 3> demosaic_pixel(const CameraFrame& frame, const std::array<Channel, 4>& tile,
                                       int row, int column) {
  std::array<uint32_t, 3> value{};
  std::array<int, 3> nearest{3, 3, 3};
  std::array<uint32_t, 3> sum{};
  std::array<uint32_t, 3> count{};
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, frame.height - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, frame.width - 1); ++c) {
      const Channel channel = tile[static_cast<size_t>((r % 2) * 2 + c % 2)];
      const int distance = std::abs(r - row) + std::abs(c - column);
      if (distance > nearest[channel]) continue;
      if (distance < nearest[channel]) {
        nearest[channel] = distance;
        sum[channel] = 0;
        count[channel] = 0;
      }
      sum[channel] +=
          frame.pixels[static_cast<size_t>(r) * frame.row_bytes() + static_cast<size_t>(c)];
      ++count[channel];
    }
  }
  for (size_t k = 0; k < 3; ++k) value[k] = count[k] == 0 ? 0 : (sum[k] + count[k] / 2) / count[k];
  return value;
}

void demosaic(const CameraFrame& frame, std::vector<uint8_t>& grey) {
  const std::array<Channel, 4> tile = bayer_tile(frame.format);
  size_t pixel = 0;
  for (int row = 0; row < frame.height; ++row) {
    for (int column = 0; column < frame.width; ++column) {
      const std::array<uint32_t, 3> bgr = demosaic_pixel(frame, tile, row, column);
      grey[pixel++] = luminance(bgr[kBlue], bgr[kGreen], bgr[kRed]);
    }
  }
}

}  // namespace

void to_grey(const CameraFrame& frame, CameraFrame& grey) {
  copy_all_but_pixels(frame, grey);
  if (frame.format == PixelFormat::kGrey8) {
    grey.pixels = frame.pixels;
  } else if (frame.format == PixelFormat::kBgr8) {
    to_luminance(frame.pixels.data(), grey.pixels.size(), grey.pixels.data());
  } else {
    demosaic(frame, grey.pixels);
  }
}

}  // namespace infuse::camera
