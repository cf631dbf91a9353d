#pragma once

#include <cstdint>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::camera {

/// Encodes an image in kGrey8 or kBgr8 as a PNG file. Fails for other formats, for an empty image,
/// and if libpng fails.
Result<std::vector<uint8_t>> encode_png(const CameraFrame& frame);

}  // namespace infuse::camera
