#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/registration/visual/camera_lidar_scan.hpp"

namespace infuse::study {

/// Sweep with the images that were taken with it, and its true pose.
struct PosedScan {
  Sweep sweep;                      ///< deskewed to the moment of the images
  std::vector<CameraFrame> images;  ///< one per camera of the rig
  Eigen::Isometry3d T_world_lidar = Eigen::Isometry3d::Identity();
};

/// Each image with its camera. Refers to both.
inline std::vector<registration::ScanImage> images_of(const PosedScan& scan,
                                                      const std::vector<CameraMount>& cameras) {
  std::vector<registration::ScanImage> images;
  for (size_t k = 0; k < cameras.size(); ++k) images.push_back({scan.images[k], cameras[k]});
  return images;
}

}  // namespace infuse::study
