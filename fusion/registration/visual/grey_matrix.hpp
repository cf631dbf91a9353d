#pragma once

#include <opencv2/core.hpp>

#include "drivers/measurement/camera_frame.hpp"

namespace infuse::registration {

/// An image, kGrey8 or kBgr8, as OpenCV's grey one (CV_8U).
cv::Mat grey_matrix(const CameraFrame& frame);

}  // namespace infuse::registration
