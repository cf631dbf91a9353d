#include "fusion/calibration/refine_intrinsics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using testing::HasSubstr;

/// No search from afar: the initial pose is the truth.
CalibrateOptions short_search() { return {.screen = {.survivors = 0}, .restarts = 0}; }

std::vector<RigCamera> one_camera(const CameraIntrinsics& intrinsics) {
  return {RigCamera{geometry::CameraModel(intrinsics)}};
}

TEST(RefineIntrinsics, FindTheFocalLength) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  CameraIntrinsics wrong = painted::small_camera();
  wrong.fx *= 1.01;
  wrong.fy *= 1.01;
  const RefinedCalibration found = calibrate_with_intrinsics(drive.scenes, one_camera(wrong),
                                                             drive.T_camera_lidar, short_search());
  ASSERT_TRUE(found.refined) << found.result.reason;
  EXPECT_NEAR(found.cameras[0].intrinsics.fx, painted::small_camera().fx, 0.005 * wrong.fx);
  EXPECT_LT(std::sqrt(found.cameras[0].covariance(0, 0)), 0.0025);
  EXPECT_GT(found.result.covariance()(5, 5), found.result.uncertainty.covariance(5, 5));
}

TEST(RefineIntrinsics, NeedEightScenes) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const auto found = calibrate_with_intrinsics(std::span(drive.scenes).first(5), drive.cameras,
                                               drive.T_camera_lidar, short_search());
  EXPECT_FALSE(found.refined);
  EXPECT_FALSE(found.result.usable());
  EXPECT_THAT(found.result.reason, HasSubstr("fewer than 8 independent scenes"));
}

TEST(RefineIntrinsics, OfTwoCamerasEachFindsItsOwn) {
  const painted::Drive& front = painted::twelve_scene_drive();
  geometry::Vector6 apart;
  apart << 0.02, 0.15, -0.01, 0.25, 0.03, -0.02;
  const Eigen::Isometry3d T_side_front = geometry::exp(apart);
  const painted::Drive side = painted::make_drive(12, 1, {}, T_side_front * front.T_camera_lidar);
  std::vector<Scene> scenes = front.scenes;
  for (Scene scene : side.scenes) {
    scene.camera = 1;
    scenes.push_back(std::move(scene));
  }
  const CameraIntrinsics truth = painted::small_camera();
  CameraIntrinsics shorter = truth, longer = truth;
  shorter.fx = shorter.fy = 0.988 * truth.fx;
  longer.fx = longer.fy = 1.012 * truth.fx;
  const std::vector<RigCamera> cameras{{geometry::CameraModel(shorter)},
                                       {geometry::CameraModel(longer), T_side_front}};
  const RefinedCalibration found =
      calibrate_with_intrinsics(scenes, cameras, front.T_camera_lidar, short_search());
  ASSERT_TRUE(found.refined) << found.result.reason;
  ASSERT_EQ(found.cameras.size(), 2U);
  EXPECT_NEAR(found.cameras[0].intrinsics.fx, truth.fx, 0.005 * truth.fx);
  EXPECT_NEAR(found.cameras[1].intrinsics.fx, truth.fx, 0.005 * truth.fx);
  EXPECT_LT(painted::degrees_between(found.result.T_refcam_lidar, front.T_camera_lidar), 0.2);
  EXPECT_EQ(found.result.scenes.size(), scenes.size());
}

/// Few returns.
TEST(RefineIntrinsics, AreRefusedWhereTheScenesDoNotDetermineThem) {
  const painted::Drive far = painted::make_drive(12, 1, {.rings = 8, .columns = 151});
  CameraIntrinsics wrong = painted::small_camera();
  wrong.cy += 4;
  const RefinedCalibration found =
      calibrate_with_intrinsics(far.scenes, one_camera(wrong), far.T_camera_lidar, short_search());
  EXPECT_FALSE(found.refined);
  EXPECT_FALSE(found.result.usable());
  EXPECT_THAT(found.result.reason, HasSubstr("do not determine the intrinsics"));
  EXPECT_EQ(found.cameras.front().intrinsics.cy, wrong.cy);
}

}  // namespace
}  // namespace infuse::calibration
