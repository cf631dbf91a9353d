#pragma once

#include "drivers/camera/picture.hpp"

namespace infuse::camera {

/// `decode_picture` for PNG, through libpng's simplified interface.
Result<void> decode_png(std::span<const uint8_t> file, const PictureOptions& options,
                        CameraFrame& frame);

}  // namespace infuse::camera
