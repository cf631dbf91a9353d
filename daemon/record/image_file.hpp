#pragma once

#include <optional>
#include <vector>

#include "drivers/camera/raw_image.hpp"

namespace infuse::daemon {

/// An image file of a drive.
struct ImageFile {
  std::vector<uint8_t> bytes;
  const char* extension = ".png";
  std::optional<PixelFormat> mosaic;  ///< set if the file is grey and holds a Bayer mosaic
  bool grey = false;                  ///< true if the pipeline ignores the file's colours
};

/// Returns the file that decodes to the image that the live pipeline unpacks: MJPEG unchanged,
/// otherwise PNG of the luma, of the colours, or of the Bayer mosaic. Errors: as `camera::unpack`.
Result<ImageFile> encode_image_file(const camera::RawImage& raw);

}  // namespace infuse::daemon
