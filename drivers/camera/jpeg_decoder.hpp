#pragma once

#include "drivers/camera/image_decoder.hpp"

namespace infuse::camera {

/// `decode_image` for JPEG, through libjpeg-turbo. Grey is decoded from the luminance alone. A
/// truncated file is an error, although the library would fill it with grey.
Result<void> decode_jpeg(std::span<const uint8_t> file, const ImageOptions& options,
                         CameraFrame& frame);

}  // namespace infuse::camera
