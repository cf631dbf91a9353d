#pragma once

#include <algorithm>
#include <cmath>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::monitoring {

/// Returns how many pixels a side are one sample of the reduced image, whose focal length is about
/// `reduced_focal_length` samples.
inline int reduction_step(const CameraIntrinsics& camera, double reduced_focal_length) {
  return std::max(1, static_cast<int>(std::lround(camera.fx / reduced_focal_length)));
}

/// Returns whether a frame is kGrey8, complete, and of the size of the intrinsics.
inline bool matches_intrinsics(const CameraFrame& grey, const CameraIntrinsics& camera) {
  return grey.format == PixelFormat::kGrey8 && grey.width == camera.width &&
         grey.height == camera.height &&
         grey.pixels.size() == grey.row_bytes() * static_cast<size_t>(grey.height);
}

}  // namespace infuse::monitoring
