#pragma once

#include "drivers/camera/image_decoder.hpp"

namespace infuse::camera {

/// `decode_image` for PNG, through libpng's simplified interface.
Result<void> decode_png(std::span<const uint8_t> file, const ImageOptions& options,
                        CameraFrame& frame);

}  // namespace infuse::camera
