#pragma once

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {

/// A picture of a map in kBgr8, north up: every id in a colour of its own, the kinds told apart by
/// hue (carriageways grey, buildings red, green areas green, water blue). Large maps are drawn
/// smaller, so that the longer edge has at most `largest` pixels.
CameraFrame draw_map(const SegmentMap& map, int largest = 8000);

}  // namespace infuse::streetmap
