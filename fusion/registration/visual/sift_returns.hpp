#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/registration/visual/camera_lidar_scan.hpp"

namespace infuse::registration {

/// Returns at SIFT keypoints of the images.
struct SiftReturns {
  std::vector<uint32_t> returns;  ///< index of the return in the sweep
  std::vector<uint32_t> camera;   ///< index of the image
  std::vector<float> u, v;        ///< keypoint, pixels
  Eigen::MatrixXf descriptors;    ///< 128 rows, one column per keypoint, unit length

  size_t size() const { return returns.size(); }
};

/// Finds the SIFT keypoints (Lowe 2004, by OpenCV) of all images that have a return within `radius`
/// pixels, P 4.4.1. Errors: an image that is neither grey nor BGR, or not of its camera's size.
Result<SiftReturns> find_sift_returns(const CameraLidarScan& scan, double radius = 1);

}  // namespace infuse::registration
