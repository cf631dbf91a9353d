#pragma once

#include <span>
#include <string>

#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// To what the time between image and sweep is known where the user does not state it.
struct TimeSigma {
  Duration sigma{0};
  std::string note;  ///< statement for the user; may be empty
};

/// By the kind of camera, the worst of them all. A global shutter is triggered, or stamped when it
/// opens: 1 ms. A rolling shutter (webcams, phones) whose delay nobody has measured
/// (`stamp_delay_sigma` is 0) is stamped when the image arrives, up to an interval between images
/// after its exposure.
TimeSigma default_time_sigma(std::span<const CameraMount> cameras);

}  // namespace infuse::daemon
