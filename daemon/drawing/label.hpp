#pragma once

#include <string_view>

#include "daemon/drawing/colour_scale.hpp"
#include "drivers/measurement/camera_frame.hpp"

namespace infuse::daemon {

/// Edge of a dot of a character, pixels.
inline constexpr int kLabelDot = 2;

/// Draws a text into an image in kBgr8, its top left corner at a pixel; what is outside is left
/// out. It has small letters, digits and some signs; others are blanks.
void draw_label(CameraFrame& image, int left, int top, std::string_view text, const Colour& colour,
                int dot = kLabelDot);

/// Pixels that a label takes.
int label_width(std::string_view text, int dot = kLabelDot);
int label_height(int dot = kLabelDot);

}  // namespace infuse::daemon
