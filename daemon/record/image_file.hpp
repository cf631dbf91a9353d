#pragma once

#include <optional>
#include <vector>

#include "drivers/camera/raw_image.hpp"

namespace infuse::daemon {

/// A picture as a drive keeps it.
struct ImageFile {
  std::vector<uint8_t> bytes;
  const char* extension = ".png";
  std::optional<PixelFormat> mosaic;  ///< set where it is a grey file of a Bayer sensor
  bool grey = false;                  ///< the pipeline leaves out the colour that the file has
};

/// Makes the file that is decoded to what the live pipeline unpacks: MJPEG as it came, else PNG of
/// the luma, of the colours, or of a Bayer sensor's values. Errors: as `camera::unpack`.
Result<ImageFile> encode_image_file(const camera::RawImage& raw);

}  // namespace infuse::daemon
