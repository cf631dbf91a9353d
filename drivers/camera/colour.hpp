#pragma once

#include "drivers/measurement/camera_frame.hpp"

namespace infuse::camera {

/// Converts `frame` to grey: luminance 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601), Bayer mosaics
/// interpolated bilinearly first. Copies everything but the pixels. Reuses the memory of `grey`,
/// which must not be `frame`.
void to_grey(const CameraFrame& frame, CameraFrame& grey);

}  // namespace infuse::camera
