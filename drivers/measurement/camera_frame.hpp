#pragma once

#include <cstdint>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Memory layout of an image's pixels.
enum class PixelFormat : uint8_t {
  kGrey8,       ///< one byte per pixel
  kBgr8,        ///< three bytes per pixel, OpenCV's channel order
  kBayerRggb8,  ///< one byte per pixel, colour by position
  kBayerBggr8,
  kBayerGbrg8,
  kBayerGrbg8,
};

/// Bytes per pixel.
constexpr int channels(PixelFormat format) { return format == PixelFormat::kBgr8 ? 3 : 1; }

/// Luminance of a colour, ITU-R BT.601, weights in 1/2^14, rounded.
constexpr uint8_t luminance(uint32_t blue, uint32_t green, uint32_t red) {
  return static_cast<uint8_t>((1868 * blue + 9617 * green + 4899 * red + 8192) >> 14);
}

/// One decoded image of a camera, rows from the top, without padding.
struct CameraFrame {
  Stamp stamp;                               ///< middle of the exposure
  Duration exposure{0};                      ///< duration of the exposure; 0 if unknown
  double gain = 0;                           ///< as the driver reports it; 0 if unknown
  uint64_t sequence = 0;                     ///< frame counter of the driver; gaps are lost frames
  int width = 0;                             ///< pixels
  int height = 0;                            ///< pixels
  PixelFormat format = PixelFormat::kGrey8;  ///< of `pixels`
  std::vector<uint8_t> pixels;               ///< width · height · channels(format) bytes

  /// Bytes of one row.
  size_t row_bytes() const {
    return static_cast<size_t>(width) * static_cast<size_t>(channels(format));
  }
};

}  // namespace infuse
