#pragma once

#include <cstdint>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// How the bytes of a picture are to be read.
enum class PixelFormat : uint8_t {
  kGrey8,       ///< one byte a pixel
  kBgr8,        ///< three bytes a pixel, OpenCV's order
  kBayerRggb8,  ///< one byte a pixel, colour by position
  kBayerBggr8,
  kBayerGbrg8,
  kBayerGrbg8,
};

/// Bytes a pixel.
constexpr int channels(PixelFormat format) { return format == PixelFormat::kBgr8 ? 3 : 1; }

/// Grey of a colour, ITU-R BT.601, weights in 1/2^14, rounded.
constexpr uint8_t luminance(uint32_t blue, uint32_t green, uint32_t red) {
  return static_cast<uint8_t>((1868 * blue + 9617 * green + 4899 * red + 8192) >> 14);
}

/// One picture of a camera, decoded, rows from the top without padding.
struct CameraFrame {
  Stamp stamp;            ///< middle of the exposure
  Duration exposure{0};   ///< how long it lasted; 0 where unknown
  double gain = 0;        ///< as the driver states it; 0 where unknown
  uint64_t sequence = 0;  ///< the driver's frame counter; gaps are lost frames
  int width = 0;          ///< pixels
  int height = 0;         ///< pixels
  PixelFormat format = PixelFormat::kGrey8;
  std::vector<uint8_t> pixels;  ///< width · height · channels(format) bytes

  /// Pixels of one row, as bytes.
  size_t row_bytes() const {
    return static_cast<size_t>(width) * static_cast<size_t>(channels(format));
  }
};

}  // namespace infuse
