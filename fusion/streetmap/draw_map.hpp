#pragma once

#include <array>
#include <cstdint>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {

/// Colour of a kind of segments: blue, green, red.
std::array<uint8_t, 3> drawn_colour(SegmentKind kind);

/// Draws a map as an image in kBgr8, north up. Each segment id has a shade of the colour of its
/// kind. A large map is reduced so that the longer edge of the image has at most `largest` pixels.
CameraFrame draw_map(const SegmentMap& map, int largest = 8000);

}  // namespace infuse::streetmap
