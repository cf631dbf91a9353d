#include "fusion/calibration/model_check.hpp"

#include <gtest/gtest.h>

#include <random>

#include "fusion/calibration/maximize.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;

/// Checks the model at the maximum next to the true pose, with `cameras`.
std::vector<ModelMismatch> mismatches_of(const std::vector<Scene>& scenes,
                                         const std::vector<RigCamera>& cameras,
                                         const Eigen::Isometry3d& T) {
  const std::vector<TermOptions>& terms = named_measures().front().terms;
  const BlurredImages images(scenes, terms, 1);
  const VisiblePoints points = select_visible(scenes, cameras, T, {});
  Objective objective(points, images, cameras, scenes, terms);
  const Eigen::Isometry3d best = maximize(objective, T, {}).T_refcam_lidar;
  return check_model(objective, best, cameras, scenes, estimate_uncertainty(objective, best));
}

TEST(CheckModel, FindsNothingWhereTheModelIsRight) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const auto mismatches = mismatches_of(drive.scenes, drive.cameras, drive.T_camera_lidar);
  ASSERT_EQ(mismatches.size(), 4U);  // the scenes have no twist
  for (const ModelMismatch& mismatch : mismatches) {
    EXPECT_FALSE(mismatch.serious)
        << mismatch.parameter << " " << mismatch.value << " " << mismatch.significance;
  }
}

TEST(CheckModel, FindsAWrongFocalLength) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  CameraIntrinsics wrong = drive.cameras[0].model.intrinsics();
  wrong.fx *= 1.01;
  wrong.fy *= 1.01;
  const auto mismatches =
      mismatches_of(drive.scenes, {RigCamera{geometry::CameraModel(wrong)}}, drive.T_camera_lidar);
  ASSERT_FALSE(mismatches.empty());
  EXPECT_EQ(mismatches[0].parameter, "focal length");
  EXPECT_TRUE(mismatches[0].significant);
  EXPECT_LT(mismatches[0].significance, -3.5);  // negative: the given one is too large
}

TEST(CheckModel, FindsAnImageDelayWhereTheMotionVaries) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  std::vector<Scene> scenes = drive.scenes;
  constexpr double kDelay = 0.006;  // s
  std::mt19937_64 random(1);
  const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1; };
  for (Scene& scene : scenes) {
    Vector6 twist;
    twist << 0, 0, 0.4 * draw(), 6 * draw(), 0, 0;
    scene.twist = twist;
    // The sweep is deskewed to a moment before the exposure: the image shows points as seen from
    // further on.
    const Eigen::Isometry3d there = geometry::exp(kDelay * twist);
    for (size_t i = 0; i < scene.size(); ++i) {
      const Eigen::Vector3d p = there * Eigen::Vector3d(scene.x[i], scene.y[i], scene.z[i]);
      scene.x[i] = static_cast<float>(p.x());
      scene.y[i] = static_cast<float>(p.y());
      scene.z[i] = static_cast<float>(p.z());
    }
  }
  const auto mismatches = mismatches_of(scenes, drive.cameras, drive.T_camera_lidar);
  ASSERT_EQ(mismatches.size(), 5U);
  EXPECT_EQ(mismatches[4].parameter, "image time offset");
  EXPECT_TRUE(mismatches[4].significant);
  EXPECT_GT(mismatches[4].significance, 3.5);
  EXPECT_NEAR(mismatches[4].value, 1e3 * kDelay, 3);
}

TEST(CheckModel, TooFewScenesGiveNoAnswer) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const std::vector<Scene> few(drive.scenes.begin(), drive.scenes.begin() + 9);
  EXPECT_TRUE(mismatches_of(few, drive.cameras, drive.T_camera_lidar).empty());
}

}  // namespace
}  // namespace infuse::calibration
