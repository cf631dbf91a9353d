#pragma once

#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// A sweep to be aligned, with the images taken nearest to its middle.
struct AlignScan {
  Sweep sweep;  ///< deskewed to the exposure of the first image, without images to its middle
  std::string deskew_reason;         ///< why it is not deskewed; empty if it is
  std::vector<CameraMount> cameras;  ///< of that lidar; empty if no images were requested
  std::vector<CameraFrame> images;   ///< one per camera
};

/// Reads a sweep: "PATH:INDEX" is sweep INDEX (from 0) of a drive folder or a capture, anything
/// else a .pcd, .ply or .bin file. `lidar` names the lidar of a drive that has several. With
/// `images`, every camera of that lidar must have an image within 50 ms.
Result<AlignScan> read_align_scan(const std::string& path, const std::string& lidar, bool images);

}  // namespace infuse::daemon
