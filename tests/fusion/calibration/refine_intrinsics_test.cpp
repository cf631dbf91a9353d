#include "fusion/calibration/refine_intrinsics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using testing::HasSubstr;

/// No search from afar: the initial pose is the truth.
CalibrateOptions short_search() { return {.screen = {.survivors = 0}, .restarts = 0}; }

TEST(RefineIntrinsics, FindTheFocalLength) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  CameraIntrinsics wrong = painted::small_camera();
  wrong.fx *= 1.01;
  wrong.fy *= 1.01;
  const RefinedCalibration found = calibrate_with_intrinsics(
      drive.scenes, {geometry::CameraModel(wrong)}, drive.T_camera_lidar, short_search());
  ASSERT_TRUE(found.refined) << found.result.reason;
  EXPECT_NEAR(found.intrinsics.fx, painted::small_camera().fx, 0.005 * wrong.fx);
  EXPECT_LT(std::sqrt(found.covariance(0, 0)), 0.0025);
  EXPECT_GT(found.result.covariance()(5, 5), found.result.uncertainty.covariance(5, 5));
}

TEST(RefineIntrinsics, NeedEightScenes) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const auto found =
      calibrate_with_intrinsics(std::span(drive.scenes).first(5), drive.cameras.front(),
                                drive.T_camera_lidar, short_search());
  EXPECT_FALSE(found.refined);
  EXPECT_FALSE(found.result.usable());
  EXPECT_THAT(found.result.reason, HasSubstr("fewer than 8 independent scenes"));
}

}  // namespace
}  // namespace infuse::calibration
