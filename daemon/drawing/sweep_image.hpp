#pragma once

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// Draws a sweep from above, twice: as measured on the left, deskewed on the right. 40 m to each
/// side, x up, without the ground. Colours run from blue at the beginning of the sweep to yellow at
/// its end, so that the seam shows the effect of the motion.
CameraFrame draw_sweep(const Sweep& sweep, const motion::DeskewedSweep& deskewed);

/// Draws two sweeps from above in the target's frame, twice: before (left) and after their
/// alignment. The target is blue, the source orange. Poses are T_target_source.
CameraFrame draw_alignment(const Sweep& target, const Sweep& source,
                           const Eigen::Isometry3d& T_before, const Eigen::Isometry3d& T_after);

}  // namespace infuse::daemon
