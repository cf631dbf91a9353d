#include "fusion/calibration/free_intrinsics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using testing::HasSubstr;

/// What the camera would rather be, from the pose that a climb with what is given leads to.
std::optional<FreedIntrinsics> freed(const std::vector<Scene>& scenes,
                                     const CameraIntrinsics& given,
                                     const std::stop_token& stop = {}) {
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(given)}};
  const std::vector<TermOptions>& terms = named_measures().front().terms;
  ImagePyramid images(scenes, terms, std::vector<double>{2});
  const Eigen::Isometry3d truth = painted::drive_of_twelve().T_camera_lidar;
  const VisiblePoints points = select_visible(scenes, cameras, truth, {});
  Objective objective(points, images.at(2), cameras, scenes, terms);
  const Eigen::Isometry3d T = maximize(objective, truth, {}).T_head_lidar;
  return free_intrinsics(scenes, cameras, 0, terms, images, {}, T, stop);
}

std::optional<ModelDoubt> doubt(const std::optional<FreedIntrinsics>& found,
                                const CameraIntrinsics& given) {
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(given)}};
  return gross_doubt(*found, cameras, 0);
}

TEST(FreeIntrinsics, StayWhereTheyAreRight) {
  const auto found = freed(painted::drive_of_twelve().scenes, painted::small_camera());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->scenes, 12);
  EXPECT_LT(std::abs(found->off(0)), 0.02);
  EXPECT_LT(found->off.segment<2>(1).cwiseAbs().maxCoeff(), 5);
  EXPECT_LT(
      painted::degrees_between(found->T_head_lidar, painted::drive_of_twelve().T_camera_lidar), 1);
  EXPECT_FALSE(doubt(found, painted::small_camera()));
}

TEST(FreeIntrinsics, FindAPrincipalPointThatIsFarOff) {
  for (const double off : {-25.0, 25.0}) {
    CameraIntrinsics wrong = painted::small_camera();
    wrong.cx += off;
    const auto found = freed(painted::drive_of_twelve().scenes, wrong);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->off(1), -off, 6);
    EXPECT_GT(found->better, 9);
    const auto told = doubt(found, wrong);
    ASSERT_TRUE(told);
    EXPECT_EQ(told->what, "principal point, across");
    EXPECT_TRUE(told->serious);
  }
}

TEST(FreeIntrinsics, FindADistortionLeftOut) {
  // The pictures of a camera without one, seen as through one that bends: as good as the converse.
  CameraIntrinsics wrong = painted::small_camera();
  wrong.distortion[0] = 0.15;
  const auto found = freed(painted::drive_of_twelve().scenes, wrong);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->off(3), -0.15, 0.05);
  const auto told = doubt(found, wrong);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->what, "radial distortion k1");
}

TEST(FreeIntrinsics, ACalibrationWithAWrongCameraIsRefused) {
  const painted::Drive& drive = painted::drive_of_twelve();
  CameraIntrinsics wrong = painted::small_camera();
  wrong.cx += 30;
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(wrong)}};
  const CalibrationResult result =
      calibrate(drive.scenes, cameras, drive.T_camera_lidar, {.restarts = 1});
  EXPECT_FALSE(result.usable());
  ASSERT_FALSE(result.doubts.empty());
  EXPECT_EQ(result.doubts.front().what, "principal point, across");
  EXPECT_TRUE(result.doubts.front().gross);
}

TEST(FreeIntrinsics, FewScenesSayNothing) {
  const std::vector<Scene>& all = painted::drive_of_twelve().scenes;
  const std::vector<Scene> few(all.begin(), all.begin() + 7);
  EXPECT_FALSE(freed(few, painted::small_camera()));
}

TEST(FreeIntrinsics, AreGivenUpWhenAskedToStop) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(freed(painted::drive_of_twelve().scenes, painted::small_camera(), stop.get_token()));
}

TEST(GrossDoubt, NeedsBothSizeAndScenesThatAgree) {
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(painted::small_camera())}};
  FreedIntrinsics found{.off = {0.03, 1, 1, 0.01}, .scenes = 20, .better = 19, .significance = 6};
  const auto told = gross_doubt(found, cameras, 0);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->what, "focal length");
  EXPECT_NEAR(told->value, 3, 1e-9);  // per cent
  found.significance = 3;
  EXPECT_FALSE(gross_doubt(found, cameras, 0));
  found.significance = 30;
  found.off(0) = 0.01;
  EXPECT_FALSE(gross_doubt(found, cameras, 0));
}

}  // namespace
}  // namespace infuse::calibration
