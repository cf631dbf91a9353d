#include "fusion/calibration/image_blur.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

RigCamera camera_of(double focal_length) {
  CameraIntrinsics model = painted::small_camera();
  model.fx = model.fy = focal_length;
  return {geometry::CameraModel(model)};
}

TEST(ImageBlur, KeepsTheAngleOfShortFocalLengthsDownToOnePixel) {
  for (const auto& [given, expected] :
       {std::pair{8.0, 4.0}, {3, 1.5}, {2, 1}, {1, 1}, {0.5, 0.5}, {0, 0}}) {
    EXPECT_DOUBLE_EQ(ImageBlur::in_angle(given).sigma(camera_of(250)), expected);
    EXPECT_DOUBLE_EQ(ImageBlur::in_angle(given).sigma(camera_of(500)), given);
    EXPECT_DOUBLE_EQ(ImageBlur::in_angle(given).sigma(camera_of(1400)), given);
  }
}

TEST(ImageBlur, InPixelsIsTheSameForEveryCamera) {
  EXPECT_DOUBLE_EQ(ImageBlur::in_pixels(8).sigma(camera_of(250)), 8);
  EXPECT_DOUBLE_EQ(ImageBlur::in_pixels(8).sigma(camera_of(1400)), 8);
  EXPECT_NE(ImageBlur::in_pixels(8), ImageBlur::in_angle(8));
}

}  // namespace
}  // namespace infuse::calibration
