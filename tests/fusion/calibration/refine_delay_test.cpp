#include "fusion/calibration/refine_delay.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

/// The scenes of a vehicle that drives at 0 to 8 m/s and up to 23°/s, with stamps that make them
/// look as if each exposure were `later` (s) than assumed.
std::vector<Scene> moving_scenes(const painted::Drive& drive, double later) {
  std::vector<Scene> scenes = drive.scenes;
  std::mt19937_64 random(1);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (Scene& scene : scenes) {
    geometry::Vector6 twist;
    twist << 0, 0, 0.8 * (uniform() - 0.5), 8 * uniform(), 0, 0;
    scene.twist = twist;
  }
  return scenes_exposed_later(scenes, -later);
}

CalibrateOptions options_of_a_known_camera() {
  CalibrateOptions options;
  options.check_intrinsics = false;
  return options;
}

TEST(RefineDelay, FindsTheDelayAndThePose) {
  const painted::Drive drive = painted::make_drive(16);
  constexpr double kLater = 0.047;
  const DelayCalibration refined =
      calibrate_with_delay(moving_scenes(drive, kLater), drive.cameras, drive.T_camera_lidar,
                           options_of_a_known_camera(), {.max_delay = 0.06});
  ASSERT_TRUE(refined.refined) << refined.result.reason;
  EXPECT_NEAR(refined.later, kLater, std::max(3 * refined.sigma, 0.002));
  EXPECT_LT(refined.sigma, 0.005);
  const Eigen::Isometry3d error = refined.result.T_refcam_lidar * drive.T_camera_lidar.inverse();
  EXPECT_LT(Eigen::AngleAxisd(error.rotation()).angle(), 0.3 * kDegree);
  EXPECT_LT(error.translation().norm(), 0.05);
}

TEST(RefineDelay, IsRefusedWhereTheMotionIsAlwaysTheSame) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  std::vector<Scene> scenes = drive.scenes;
  for (Scene& scene : scenes) {
    scene.twist = geometry::Vector6::Zero();
    (*scene.twist)(3) = 8;
  }
  const DelayCalibration refined =
      calibrate_with_delay(scenes, drive.cameras, drive.T_camera_lidar, options_of_a_known_camera(),
                           {.max_delay = 0.06});
  EXPECT_FALSE(refined.refined);
  EXPECT_NE(refined.result.reason.find("do not determine the delay"), std::string::npos)
      << refined.result.reason;
}

TEST(RefineDelay, IsRefusedWithoutTheVehiclesMotion) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const DelayCalibration refined =
      calibrate_with_delay(drive.scenes, drive.cameras, drive.T_camera_lidar,
                           options_of_a_known_camera(), {.max_delay = 0.06});
  EXPECT_FALSE(refined.refined);
  EXPECT_NE(refined.result.reason.find("motion is not known"), std::string::npos);
}

TEST(RefineDelay, OptionsSayWhatIsWrong) {
  EXPECT_FALSE(DelayOptions{}.invalid());
  EXPECT_TRUE(DelayOptions{.max_delay = 1}.invalid());
  EXPECT_TRUE((DelayOptions{.max_delay = 0.01, .step = 0.02}).invalid());
  EXPECT_TRUE(DelayOptions{.max_sigma = 0}.invalid());
}

}  // namespace
}  // namespace infuse::calibration
