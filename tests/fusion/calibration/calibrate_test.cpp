#include "fusion/calibration/calibrate.hpp"
#include "drivers/measurement/angles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "fusion/calibration/named_measures.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;
using painted::degrees_between;
using painted::Drive;
using painted::metres_between;
using testing::HasSubstr;

const Drive& eight_scene_drive() {
  static const Drive drive = painted::make_drive(8);
  return drive;
}

Eigen::Isometry3d perturbed(const Eigen::Isometry3d& T, double degrees, double metres) {
  const double r = degrees * kDegree / std::sqrt(3.0);
  const double t = metres / std::sqrt(3.0);
  Vector6 xi;
  xi << r, -r, r, -t, t, t;
  return geometry::exp(xi) * T;
}

TEST(Calibrate, ConvergesFromThreeDegreesAndTenCentimetres) {
  const Drive& drive = eight_scene_drive();
  const auto start = perturbed(drive.T_camera_lidar, 3, 0.1);
  const CalibrationResult result = calibrate(drive.scenes, drive.cameras, start, {});
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_LT(degrees_between(result.T_refcam_lidar, drive.T_camera_lidar), 0.1);
  EXPECT_LT(metres_between(result.T_refcam_lidar, drive.T_camera_lidar), 0.02);
  EXPECT_GT(result.value, result.initial_value);
  EXPECT_GT(result.support, 0.9);
  EXPECT_TRUE(result.best_of_restarts);
}

TEST(Calibrate, StaysAtTheTruth) {
  const Drive& drive = eight_scene_drive();
  const CalibrationResult result = calibrate(drive.scenes, drive.cameras, drive.T_camera_lidar, {});
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_LT(degrees_between(result.T_refcam_lidar, drive.T_camera_lidar), 0.1);
  EXPECT_LT(metres_between(result.T_refcam_lidar, drive.T_camera_lidar), 0.02);
}

TEST(Calibrate, TheCovarianceCoversTheError) {
  const Drive drive = painted::make_drive(20);
  const CalibrationResult result = calibrate(drive.scenes, drive.cameras, drive.T_camera_lidar, {});
  ASSERT_TRUE(result.usable()) << result.reason;
  const Vector6 error = geometry::log(result.T_refcam_lidar * drive.T_camera_lidar.inverse());
  // The spread itself comes from 20 scenes: 99.9 % of Fisher's F with 6 and 14 degrees of freedom
  // lie below 7.44.
  const geometry::Matrix6 scatter =
      result.uncertainty.covariance - result.uncertainty.bias_covariance;
  EXPECT_LT(error.dot(scatter.inverse() * error), 6 * 7.44);
  EXPECT_LT(std::sqrt(scatter.diagonal().head<3>().maxCoeff()), 0.05 * kDegree);
  EXPECT_LT(std::sqrt(scatter.diagonal().tail<3>().maxCoeff()), 0.01);
  EXPECT_LT(std::sqrt(result.uncertainty.covariance.diagonal().head<3>().maxCoeff()),
            0.2 * kDegree);
}

TEST(Calibrate, TheSameSeedGivesTheSameBytes) {
  const Drive& drive = eight_scene_drive();
  const CalibrateOptions options{.fine = {{.sigma = 2}}, .restarts = 2};
  const auto start = perturbed(drive.T_camera_lidar, 1, 0.05);
  const auto a = calibrate(drive.scenes, drive.cameras, start, options);
  const auto b = calibrate(drive.scenes, drive.cameras, start, options);
  EXPECT_EQ(a.T_refcam_lidar.matrix(), b.T_refcam_lidar.matrix());
  EXPECT_EQ(a.uncertainty.covariance, b.uncertainty.covariance);
}

TEST(Calibrate, ImagesOfOtherPlacesAreRejected) {
  Drive drive = eight_scene_drive();
  std::rotate(drive.scenes.begin(), drive.scenes.begin() + 3, drive.scenes.end());
  std::vector<PerImageFeature<features::Plane>> images;
  for (const Scene& scene : drive.scenes) images.push_back(scene.image);
  for (size_t s = 0; s < images.size(); ++s)
    drive.scenes[s].image = images[(s + 3) % images.size()];
  const auto result = calibrate(drive.scenes, drive.cameras, drive.T_camera_lidar, {});
  EXPECT_FALSE(result.usable());
  EXPECT_LT(result.support, 0.75);
}

TEST(Calibrate, ConstantImagesAreRejected) {
  Drive drive = eight_scene_drive();
  for (Scene& scene : drive.scenes) {
    for (features::Plane& plane : scene.image)
      std::fill(plane.values.begin(), plane.values.end(), 0.5F);
  }
  const auto result = calibrate(drive.scenes, drive.cameras, drive.T_camera_lidar, {});
  EXPECT_FALSE(result.usable());
  EXPECT_EQ(result.T_refcam_lidar.matrix(), drive.T_camera_lidar.matrix());
}

TEST(Calibrate, TwoScansAreTooFew) {
  const Drive& drive = eight_scene_drive();
  const auto result = calibrate(std::span(drive.scenes).first(2), drive.cameras,
                                drive.T_camera_lidar, {.restarts = 0});
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(result.reason, HasSubstr("at least 3"));
}

TEST(Calibrate, NothingInViewIsRefused) {
  const Drive& drive = eight_scene_drive();
  Eigen::Isometry3d backwards = drive.T_camera_lidar;
  backwards.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()) * backwards.linear();
  const auto result = calibrate(drive.scenes, drive.cameras, backwards, {.restarts = 0});
  EXPECT_FALSE(result.usable());
  EXPECT_FALSE(result.has_pose);
  EXPECT_EQ(result.points, 0U);
}

TEST(Calibrate, FarFieldAloneLeavesTheTranslationUnobservable) {
  const Drive drive = painted::make_drive(8, 160);  // all 640 m away or more
  const auto result = calibrate(drive.scenes, drive.cameras, drive.T_camera_lidar, {});
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(result.reason, HasSubstr("translation"));
  EXPECT_LT(degrees_between(result.T_refcam_lidar, drive.T_camera_lidar), 0.3);
}

TEST(Calibrate, ConvergesFromAWideRotation) {
  const Drive& drive = eight_scene_drive();
  const auto start = perturbed(drive.T_camera_lidar, 12, 0.05);
  CalibrateOptions options;
  options.screen.half_width = 10 * kDegree;
  const CalibrationResult result = calibrate(drive.scenes, drive.cameras, start, options);
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_LT(degrees_between(result.T_refcam_lidar, drive.T_camera_lidar), 0.1);
  EXPECT_LT(metres_between(result.T_refcam_lidar, drive.T_camera_lidar), 0.02);
}

/// Rings run down the image. By depth edges alone, P 6.2.1.
TEST(Calibrate, ConvergesForACameraRolledBy90Degrees) {
  const Eigen::Isometry3d T =
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()) * painted::true_T_camera_lidar();
  const Drive drive = painted::make_drive(20, 1, {}, T);
  // Edges along the rings say little of a turn across them, which the stated covariance shows.
  const CalibrateOptions options{.terms = find_measure("edges")->terms,
                                 .max_rotation_sigma = 1 * kDegree,
                                 .max_translation_sigma = 0.2};
  const CalibrationResult result =
      calibrate(drive.scenes, drive.cameras, perturbed(T, 1, 0.05), options);
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_LT(degrees_between(result.T_refcam_lidar, T), 0.5);
  EXPECT_LT(metres_between(result.T_refcam_lidar, T), 0.05);
}

TEST(Calibrate, StopsWhateverTheNumberOfInitialPoses) {
  const Drive& drive = eight_scene_drive();
  const int many = 20'000;
  std::stop_source stop;
  CalibrateOptions options{.restarts = many, .restarts_of_few = many};
  options.screen.survivors = many;
  options.coarse.front().survivors = many;
  options.maximize.stop = stop.get_token();
  std::jthread stopper([&] { stop.request_stop(); });
  const auto start = perturbed(drive.T_camera_lidar, 3, 0.1);
  const auto result = calibrate(drive.scenes, drive.cameras, start, options);
  EXPECT_EQ(result.reason, kCancelled);
  EXPECT_EQ(result.T_refcam_lidar.matrix(), start.matrix());
  // Without the stop it would need at least one evaluation per initial pose.
  EXPECT_LT(result.evaluations, many);
}

TEST(CalibrateOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(CalibrateOptions{}.invalid());
  EXPECT_THAT(*(CalibrateOptions{.fine = {}}.invalid()), HasSubstr("fine"));
  EXPECT_THAT(*(CalibrateOptions{.fine = {{.sigma = -1}}}.invalid()), HasSubstr("sigma"));
  EXPECT_THAT(*(CalibrateOptions{.coarse = {}}.invalid()), HasSubstr("coarse"));
  EXPECT_THAT(*(CalibrateOptions{.screen = {.half_width = -1}}.invalid()), HasSubstr("screen"));
  EXPECT_THAT(*(CalibrateOptions{.restarts = -1}.invalid()), HasSubstr("restarts"));
  EXPECT_THAT(*(CalibrateOptions{.restarts_of_few = 3}.invalid()), HasSubstr("restarts_of_few"));
  EXPECT_THAT(*(CalibrateOptions{.fine_restarts = -1}.invalid()), HasSubstr("fine_restarts"));
  EXPECT_THAT(*(CalibrateOptions{.min_support = 2}.invalid()), HasSubstr("min_support"));
  EXPECT_THAT(*(CalibrateOptions{.maximize = {.max_iterations = 0}}.invalid()),
              HasSubstr("maximize"));
}

}  // namespace
}  // namespace infuse::calibration
