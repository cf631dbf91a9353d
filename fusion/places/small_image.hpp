#pragma once

#include <cstdint>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"

namespace infuse::places {

/// Reduces a grey image (kGrey8) to `width` × `height` pixels, row by row without padding: each is
/// the mean of those it covers, or the nearest one where the image is smaller.
std::vector<uint8_t> shrink_image(const CameraFrame& frame, int width, int height);

}  // namespace infuse::places
