#pragma once

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// A sweep from above, twice: on the left as it was measured, on the right corrected for motion.
/// 40 m to each side, x up, the ground left out; returns are blue at the beginning of the sweep and
/// red at its end, so that the seam shows what the motion did.
CameraFrame draw_sweep(const Sweep& sweep, const motion::DeskewedSweep& deskewed);

}  // namespace infuse::daemon
