#include "fusion/calibration/estimate_intrinsics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

/// Estimates the intrinsics, from the pose that an ascent with the given ones converges to.
std::optional<IntrinsicsEstimate> estimate_for(const std::vector<Scene>& scenes,
                                               const CameraIntrinsics& given,
                                               const std::stop_token& stop = {}) {
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(given)}};
  const std::vector<TermOptions>& terms = named_measures().front().terms;
  ImagePyramid images(scenes, cameras, terms, std::vector<ImageBlur>{ImageBlur::in_angle(2)});
  const Eigen::Isometry3d truth = painted::twelve_scene_drive().T_camera_lidar;
  const VisiblePoints points = select_visible(scenes, cameras, truth, {});
  Objective objective(points, images.at(ImageBlur::in_angle(2)), cameras, scenes, terms);
  const Eigen::Isometry3d T = maximize(objective, truth, {}).T_refcam_lidar;
  return estimate_intrinsics(scenes, cameras, 0, terms, terms, images, {}, T,
                             {.effective_scenes = static_cast<double>(scenes.size())}, stop);
}

std::optional<ParameterCheck> gross_error(const std::optional<IntrinsicsEstimate>& found,
                                          const CameraIntrinsics& given) {
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(given)}};
  return detect_gross_error(*found, cameras, 0, {});
}

TEST(EstimateIntrinsics, StayIfTheyAreRight) {
  const auto found = estimate_for(painted::twelve_scene_drive().scenes, painted::small_camera());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->scenes, 12);
  EXPECT_LT(std::abs(found->correction(0)), 0.02);
  EXPECT_LT(found->correction.segment<2>(1).cwiseAbs().maxCoeff(), 5);
  EXPECT_LT(
      painted::degrees_between(found->T_refcam_lidar, painted::twelve_scene_drive().T_camera_lidar),
      1);
  EXPECT_FALSE(gross_error(found, painted::small_camera()));
}

TEST(EstimateIntrinsics, FindAGrossErrorOfThePrincipalPoint) {
  for (const double off : {-25.0, 25.0}) {
    CameraIntrinsics wrong = painted::small_camera();
    wrong.cx += off;
    const auto found = estimate_for(painted::twelve_scene_drive().scenes, wrong);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->correction(1), -off, 6);
    EXPECT_GT(found->improved_scenes, 9);
    const auto check = gross_error(found, wrong);
    ASSERT_TRUE(check);
    EXPECT_EQ(check->parameter, "principal point cx");
    EXPECT_TRUE(check->serious);
  }
}

TEST(EstimateIntrinsics, FindAMissingDistortion) {
  // Images of a camera without distortion, with intrinsics that have one: equivalent to the
  // converse.
  CameraIntrinsics wrong = painted::small_camera();
  wrong.distortion[0] = 0.15;
  const auto found = estimate_for(painted::twelve_scene_drive().scenes, wrong);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->correction(3), -0.15, 0.05);
  const auto check = gross_error(found, wrong);
  ASSERT_TRUE(check);
  EXPECT_EQ(check->parameter, "radial distortion k1");
}

TEST(EstimateIntrinsics, ACalibrationWithAWrongCameraIsRefused) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  CameraIntrinsics wrong = painted::small_camera();
  wrong.cx += 30;
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(wrong)}};
  const CalibrationResult result =
      calibrate(drive.scenes, cameras, drive.T_camera_lidar, {.restarts = 1});
  EXPECT_FALSE(result.usable());
  ASSERT_FALSE(result.parameter_checks.empty());
  EXPECT_EQ(result.parameter_checks.front().parameter, "principal point cx");
  EXPECT_TRUE(result.parameter_checks.front().gross);
}

TEST(EstimateIntrinsics, ACalibrationStatesWhichErrorsMayGoUnnoticed) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(painted::small_camera())}};
  const CalibrationResult result =
      calibrate(drive.scenes, cameras, drive.T_camera_lidar, {.restarts = 1});
  ASSERT_TRUE(result.intrinsics.front());
  ASSERT_GE(result.parameter_checks.size(), 4U);
  const IntrinsicsEstimate& estimate = *result.intrinsics.front();
  for (size_t i = 0; i < 4; ++i) {
    ASSERT_TRUE(result.parameter_checks[i].detection_limit);
    const double per_unit = i == 0 ? 100 : 1;  // per cent
    const double limit = *result.parameter_checks[i].detection_limit / per_unit;
    EXPECT_LT(std::abs(estimate.correction(static_cast<Eigen::Index>(i))), limit);
  }
}

TEST(EstimateIntrinsics, FewScenesGiveNoEstimate) {
  const std::vector<Scene>& all = painted::twelve_scene_drive().scenes;
  const std::vector<Scene> few(all.begin(), all.begin() + 7);
  EXPECT_FALSE(estimate_for(few, painted::small_camera()));
}

TEST(EstimateIntrinsics, StopsWhenRequested) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(estimate_for(painted::twelve_scene_drive().scenes, painted::small_camera(),
                            stop.get_token()));
}

TEST(DetectGrossError, ComparesTheCorrectionWithWhatIsKnown) {
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(painted::small_camera())}};
  IntrinsicsEstimate found{.correction = {0.03, 1, 1, 0.01}, .significance = 6};
  found.covariance = Eigen::Vector4d(0.002, 1, 1, 0.01).cwiseAbs2().asDiagonal();
  const auto check = detect_gross_error(found, cameras, 0, {});
  ASSERT_TRUE(check);
  EXPECT_EQ(check->parameter, "focal length");
  EXPECT_NEAR(check->value, 3, 1e-9);  // per cent
  EXPECT_FALSE(detect_gross_error(found, cameras, 0, {.focal_sigma = 0.03}));
  found.significance = -1;  // the scenes fit worse
  EXPECT_FALSE(detect_gross_error(found, cameras, 0, {}));
  found.significance = 6;
  found.covariance(0, 0) = 1e-3;  // the scenes do not determine it
  EXPECT_FALSE(detect_gross_error(found, cameras, 0, {}));
}

TEST(DetectionLimits, AreWhereTheTestBegins) {
  const std::vector<RigCamera> cameras{RigCamera{geometry::CameraModel(painted::small_camera())}};
  IntrinsicsEstimate found{.significance = 6};
  const Eigen::Vector4d sigma(0.002, 2, 9, 0.01);
  found.covariance = sigma.cwiseAbs2().asDiagonal();
  found.covariance(1, 3) = found.covariance(3, 1) = 0.8 * sigma(1) * sigma(3);
  const KnownParameters known;
  const Eigen::Vector4d limits = detection_limits(found, known);
  for (Eigen::Index i = 0; i < 4; ++i) {
    found.correction = 0.999 * limits(i) * Eigen::Vector4d::Unit(i);
    EXPECT_FALSE(detect_gross_error(found, cameras, 0, known));
    found.correction = 1.001 * limits(i) * Eigen::Vector4d::Unit(i);
    EXPECT_TRUE(detect_gross_error(found, cameras, 0, known));
  }
  EXPECT_NEAR(limits(2), 34, 1);  // 3.64 standard deviations of 9.2 px
}

TEST(UnseenErrors, AreThoseOfDrawnCamerasThatTheTestDoesNotShow) {
  IntrinsicsEstimate estimate;
  estimate.covariance = Eigen::Vector4d(0.01, 8, 30, 0.03).cwiseAbs2().asDiagonal();
  const Eigen::Vector4d found = unseen_errors(estimate, 1000, {});
  const Eigen::Vector4d uncalibrated(0.02, 20, 20, 0.1);
  const Eigen::Vector4d noise(std::hypot(0.01, 0.002, 0.005), std::hypot(8, 0.5, 1.5),
                              std::hypot(30, 0.5, 1.5), std::hypot(0.03, 0.005, 0.005));
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 200'000;
  for (Eigen::Index i = 0; i < 4; ++i) {
    double sum = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const double error = uncalibrated(i) * normal(random);
      const double estimated = error + noise(i) * normal(random);
      if (estimated * estimated <= 13.28 * noise(i) * noise(i)) sum += error * error;
    }
    const double expected = std::sqrt(0.005 * sum / kDraws);
    EXPECT_NEAR(found(i), expected, 0.02 * expected) << i;
  }
}

TEST(UnseenErrors, VanishWhereTheScenesDetermineTheIntrinsics) {
  IntrinsicsEstimate estimate;
  estimate.covariance = Eigen::Vector4d(1e-4, 0.01, 0.01, 1e-4).cwiseAbs2().asDiagonal();
  const Eigen::Vector4d found = unseen_errors(estimate, 1000, {});
  EXPECT_LT(found(0), 0.002);
  EXPECT_LT(found(1), 1);
  EXPECT_LT(found(3), 0.005);
}

TEST(UnmeasuredErrors, AreThoseOfDrawnCamerasWithThisEstimate) {
  IntrinsicsEstimate estimate{.correction = {0.01, -6, 25, 0.05}};
  estimate.covariance = Eigen::Vector4d(0.01, 8, 30, 0.03).cwiseAbs2().asDiagonal();
  const Eigen::Vector4d found = unmeasured_errors(estimate, 1000, {});
  const Eigen::Vector4d uncalibrated(0.02, 20, 20, 0.1);
  const Eigen::Vector4d noise(std::hypot(0.01, 0.002, 0.005), std::hypot(8, 0.5, 1.5),
                              std::hypot(30, 0.5, 1.5), std::hypot(0.03, 0.005, 0.005));
  EXPECT_EQ(unmeasured_errors(std::nullopt, 1000, {}), uncalibrated);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (Eigen::Index i = 0; i < 4; ++i) {
    double sum = 0, alike = 0;
    while (alike < 10'000) {
      const double error = uncalibrated(i) * normal(random);
      const double estimated = error + noise(i) * normal(random);
      if (std::abs(estimated - estimate.correction(i)) > 0.1 * noise(i)) continue;
      sum += error * error;
      ++alike;
    }
    const double expected = std::sqrt(sum / alike);
    EXPECT_NEAR(found(i), expected, 0.03 * expected) << i;
  }
}

}  // namespace
}  // namespace infuse::calibration
