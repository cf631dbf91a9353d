#pragma once

#include <span>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/target/calibrate_intrinsics.hpp"

namespace infuse::daemon {

/// Draws where in the image the corners of the used views are, and by how much each is off: dark
/// where a cell of the coverage has none; a line from each corner along its error, 100 times as
/// long, coloured by its length (blue none, yellow three times the noise); outlier views white; the
/// radius within which the distortion is determined as a circle. The legend is below the image. An
/// image larger than 1280 pixels is drawn smaller.
CameraFrame draw_intrinsics(const target::IntrinsicsResult& result,
                            std::span<const target::Corners> views);

}  // namespace infuse::daemon
