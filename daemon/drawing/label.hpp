#pragma once

#include <string_view>

#include "daemon/drawing/colour_scale.hpp"
#include "drivers/measurement/camera_frame.hpp"

namespace infuse::daemon {

/// Draws a text into an image in kBgr8, its top left corner at a pixel; what is outside is left
/// out. It has the characters of the labels of this folder: some small letters and digits; others
/// are blanks.
void draw_label(CameraFrame& image, int left, int top, std::string_view text, const Colour& colour);

/// Pixels that a label takes.
int label_width(std::string_view text);
int label_height();

}  // namespace infuse::daemon
