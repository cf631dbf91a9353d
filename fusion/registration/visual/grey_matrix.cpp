#include "fusion/registration/visual/grey_matrix.hpp"

#include <algorithm>

#include "fusion/features/plane.hpp"

namespace infuse::registration {

cv::Mat grey_matrix(const CameraFrame& frame) {
  const features::Plane grey = features::grey_plane(frame);
  cv::Mat image(grey.height, grey.width, CV_8U);
  for (int row = 0; row < grey.height; ++row) {
    std::transform(grey.row(row), grey.row(row) + grey.width, image.ptr<uint8_t>(row),
                   [](float level) { return static_cast<uint8_t>(level); });
  }
  return image;
}

}  // namespace infuse::registration
