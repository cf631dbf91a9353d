#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::camera {

/// Options for decoding an image file.
struct ImageOptions {
  /// Bayer pattern of a one-channel file of raw sensor values; colour files are then refused.
  std::optional<PixelFormat> bayer{};
  /// Decode to grey even if the file has colour.
  bool grey = false;
  /// Maximum number of pixels; larger images are refused before any pixel is read.
  int64_t max_pixels = 64'000'000;

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Decodes a PNG or JPEG file into `frame`: sets width, height, format and pixels, and leaves the
/// other members. One-channel files become kGrey8 (or the Bayer format requested), colour becomes
/// kBgr8, transparency is blended with black; 16 bits per channel are reduced to 8. Reuses the
/// frame's memory if it suffices; its content after a failure is unspecified.
///
/// Errors: neither PNG nor JPEG, damaged or truncated, too large, colour instead of a Bayer mosaic.
Result<void> decode_image(std::span<const uint8_t> file, const ImageOptions& options,
                          CameraFrame& frame);

}  // namespace infuse::camera
