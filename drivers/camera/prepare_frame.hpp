#pragma once

#include "drivers/camera/image_decoder.hpp"

namespace infuse::camera {

/// Checks a file's size against the options and sets the frame's size, format and memory for it.
Result<void> prepare_frame(int64_t width, int64_t height, bool colour, const ImageOptions& options,
                           CameraFrame& frame);

}  // namespace infuse::camera
