#pragma once

#include "drivers/measurement/camera_frame.hpp"

namespace infuse::camera {

/// `frame` in grey: luminance 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601), Bayer mosaics
/// interpolated bilinearly first. Everything but the pixels is copied. `grey` keeps its memory; it
/// must not be `frame`.
void to_grey(const CameraFrame& frame, CameraFrame& grey);

/// `frame` in kBgr8; a grey picture gets three equal channels. As `to_grey` otherwise.
void to_bgr(const CameraFrame& frame, CameraFrame& bgr);

}  // namespace infuse::camera
