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
std::vector<ParameterCheck> checks_of(const std::vector<Scene>& scenes,
                                      const std::vector<RigCamera>& cameras,
                                      const Eigen::Isometry3d& T) {
  const std::vector<TermOptions>& terms = named_measures().front().terms;
  const BlurredImages images(scenes, cameras, terms, ImageBlur::in_angle(1));
  const VisiblePoints points = select_visible(scenes, cameras, T, {});
  Objective objective(points, images, cameras, scenes, terms);
  const Eigen::Isometry3d best = maximize(objective, T, {}).T_refcam_lidar;
  return check_model(best, cameras.size(), scenes, estimate_uncertainty(objective, best));
}

TEST(CheckModel, FindsNothingWhereTheModelIsRight) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const auto checks = checks_of(drive.scenes, drive.cameras, drive.T_camera_lidar);
  ASSERT_EQ(checks.size(), 4U);  // the scenes have no twist
  for (const ParameterCheck& check : checks) {
    EXPECT_FALSE(check.serious) << check.parameter << " " << check.value << " "
                                << check.significance;
  }
}

TEST(CheckModel, FindsAWrongFocalLength) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  CameraIntrinsics wrong = drive.cameras[0].model.intrinsics();
  wrong.fx *= 1.02;
  wrong.fy *= 1.02;
  const auto checks =
      checks_of(drive.scenes, {RigCamera{geometry::CameraModel(wrong)}}, drive.T_camera_lidar);
  ASSERT_FALSE(checks.empty());
  EXPECT_EQ(checks[0].parameter, "focal length");
  EXPECT_TRUE(checks[0].significant);
  EXPECT_NEAR(checks[0].value, -2, 0.8) << "negative: the given one is too large";
}

TEST(CheckModel, FindsAnImageDelayWhereTheMotionVaries) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  std::vector<Scene> scenes = drive.scenes;
  constexpr double kDelay = 0.01;  // s
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
  const auto checks = checks_of(scenes, drive.cameras, drive.T_camera_lidar);
  ASSERT_EQ(checks.size(), 5U);
  EXPECT_EQ(checks[4].parameter, "image time offset");
  EXPECT_GT(checks[4].significance, 3);
  EXPECT_NEAR(checks[4].value, 1e3 * kDelay, 4);
}

TEST(CheckModel, TooFewScenesGiveNoAnswerButTheSensitivities) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const std::vector<Scene> few(drive.scenes.begin(), drive.scenes.begin() + 9);
  const auto parameters = checks_of(few, drive.cameras, drive.T_camera_lidar);
  ASSERT_EQ(parameters.size(), 4U);
  for (const ParameterCheck& one : parameters) {
    EXPECT_EQ(one.significance, 0);
    EXPECT_FALSE(one.significant);
  }
  // A centre that is 1 px to the right turns the camera by about 1 / f about its vertical axis.
  EXPECT_NEAR(std::abs(parameters[1].pose_sensitivity(1)), 1 / 330.0, 1.5e-3);
}

TEST(ModelCovariance, AddsTheParametersByTheirSigmas) {
  std::vector<ParameterCheck> parameters(2);
  parameters[0].known_sigma = 2;
  parameters[0].pose_sensitivity = 3 * Vector6::Unit(1);
  parameters[1].known_sigma = 0.5;
  parameters[1].pose_sensitivity = Vector6::Unit(1) + Vector6::Unit(4);
  const geometry::Matrix6 scenes = geometry::Matrix6::Identity();
  const geometry::Matrix6 covariance = model_covariance(parameters, scenes);
  EXPECT_DOUBLE_EQ(covariance(1, 1), 36.25);
  EXPECT_DOUBLE_EQ(covariance(1, 4), 0.25);
  EXPECT_DOUBLE_EQ(covariance(4, 4), 0.25);
  EXPECT_DOUBLE_EQ(covariance(0, 0), 0);
  parameters[0].tolerance = 1.5;  // with the known sigma 2.5
  parameters[0].value = -10;      // mean square 10 with the other
  parameters[1].value = 1;
  EXPECT_DOUBLE_EQ(model_covariance(parameters, scenes)(0, 0), 9);
  EXPECT_DOUBLE_EQ(model_covariance(parameters, scenes)(1, 4), 0.25);
}

TEST(KnownParameters, SayWhatIsWrong) {
  EXPECT_EQ(KnownParameters{}.invalid(), std::nullopt);
  EXPECT_TRUE(KnownParameters{.focal_sigma = -1}.invalid());
  EXPECT_TRUE(KnownParameters{.principal_point_sigma = 1e3}.invalid());
  EXPECT_TRUE(KnownParameters{.radial_sigma = std::nan("")}.invalid());
  EXPECT_TRUE(KnownParameters{.time_sigma = Duration{-1}}.invalid());
}

}  // namespace
}  // namespace infuse::calibration
