#pragma once

#include <cstdint>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::camera {

/// Encodes an image as JPEG; an image in a Bayer format as a grey one. `quality`: 1 … 100. `file`
/// keeps its memory. Fails for an empty image, and if libjpeg-turbo fails.
Result<void> encode_jpeg(const CameraFrame& frame, int quality, std::vector<uint8_t>& file);

}  // namespace infuse::camera
