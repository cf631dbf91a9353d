#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::camera {

/// How a picture file is to be read.
struct ImageOptions {
  /// Set where the file is one channel of raw sensor values; colour files are then refused.
  std::optional<PixelFormat> bayer{};
  /// Decode to grey even where the file has colour.
  bool grey = false;
  /// Larger pictures are refused before any of their pixels is read.
  int64_t max_pixels = 64'000'000;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Decodes a PNG or JPEG file into `frame`: sets width, height, format and pixels, and leaves the
/// rest. One-channel files become kGrey8 (or the Bayer format requested), colour becomes kBgr8,
/// transparency is laid on black; 16 bits a channel are reduced to 8. The frame's memory is reused
/// where it suffices; what it holds after a failure is not specified.
///
/// Errors: neither PNG nor JPEG, damaged or cut off, too large, colour where a Bayer mosaic is
/// expected.
Result<void> decode_image(std::span<const uint8_t> file, const ImageOptions& options,
                          CameraFrame& frame);

}  // namespace infuse::camera
