#pragma once

#include <cstdint>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::camera {

/// The PNG file of a picture in kGrey8 or kBgr8. Fails for other formats, for an empty picture, and
/// where libpng does.
Result<std::vector<uint8_t>> encode_png(const CameraFrame& frame);

}  // namespace infuse::camera
