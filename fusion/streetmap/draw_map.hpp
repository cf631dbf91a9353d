#pragma once

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {

/// Draws a map as an image in kBgr8, north up. Each segment id has its own colour; the hue shows
/// the kind (carriageways grey, buildings red, green areas green, water blue). A large map is
/// reduced so that the longer edge of the image has at most `largest` pixels.
CameraFrame draw_map(const SegmentMap& map, int largest = 8000);

}  // namespace infuse::streetmap
