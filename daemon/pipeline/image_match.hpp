#pragma once

#include <cstdint>
#include <string_view>

#include "daemon/pipeline/image_thread.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/setup/sensor_id.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// A sweep, and its returns as of one moment. Refers to objects that live longer.
struct SweepSnapshot {
  LidarIndex lidar;
  const Sweep& sweep;
  const motion::DeskewedSweep& deskewed;  ///< returns in the lidar frame at `deskewed.reference`
};

/// An image, and the sweep during which it was exposed. Refers to objects that live longer.
struct ImageMatch {
  const CameraImage& image;
  SweepSnapshot snapshot;                   ///< as of the exposure; valid if `usable()`
  const Eigen::Isometry3d& T_camera_lidar;  ///< calibration in use
  uint32_t points_in_view = 0;              ///< returns that project into the image
  const char* reason = "";  ///< static text: why image and sweep do not match; empty if they do

  bool usable() const { return *reason == '\0'; }
};

/// Returns the FRAME report of a match. `device`: name of the camera, which outlives the report.
FrameReport summarise(const ImageMatch& match, std::string_view device);

}  // namespace infuse::daemon
