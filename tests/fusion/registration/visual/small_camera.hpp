#pragma once

#include "drivers/measurement/rig.hpp"

namespace infuse::registration {

/// A camera of 160 x 120 pixels at the lidar's origin that looks along the lidar's x axis.
inline CameraMount small_camera() {
  CameraMount camera{.name = "front"};
  CameraIntrinsics& k = camera.intrinsics;
  k.width = 160;
  k.height = 120;
  k.fx = k.fy = 100;
  k.cx = 79.5;
  k.cy = 59.5;
  camera.T_camera_lidar.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return camera;
}

}  // namespace infuse::registration
