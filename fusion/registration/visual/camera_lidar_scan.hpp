#pragma once

#include <span>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/features/sweep_view.hpp"

namespace infuse::registration {

/// Image with the camera that took it. Refers to both.
struct ScanImage {
  const CameraFrame& frame;  ///< kGrey8 or kBgr8
  const CameraMount& camera;
};

/// Sweep, deskewed to the moment of its images. Refers to both.
struct CameraLidarScan {
  features::SweepView sweep;
  std::span<const ScanImage> images;
};

}  // namespace infuse::registration
