#include "fusion/calibration/any_heading.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

CalibrateOptions screening_options() {
  CalibrateOptions options;
  options.check_intrinsics = false;
  options.screen_points = 6'000;
  options.coarse_points = options.fine_points = 20'000;
  return options;
}

/// The true pose turned about the lidar's vertical axis and tilted, its centre displaced.
Eigen::Isometry3d wrong_start(const Eigen::Isometry3d& T_camera_lidar, double heading) {
  Eigen::Isometry3d T = T_camera_lidar * Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ());
  T = Eigen::AngleAxisd(8 * kDegree, Eigen::Vector3d(1, 0.3, -0.5).normalized()) * T;
  T.translation() += Eigen::Vector3d(0.1, -0.1, 0.1);
  return T;
}

TEST(AnyHeading, FindsTheCameraWhereverItLooks) {
  const painted::Drive drive = painted::make_drive(10);
  const CalibrationResult result =
      calibrate_any_heading(drive.scenes, drive.cameras,
                            wrong_start(drive.T_camera_lidar, 195 * kDegree), screening_options());
  ASSERT_TRUE(result.usable()) << result.reason;
  const Eigen::Isometry3d error = result.T_refcam_lidar * drive.T_camera_lidar.inverse();
  EXPECT_LT(Eigen::AngleAxisd(error.rotation()).angle(), 0.3 * kDegree);
  EXPECT_LT(error.translation().norm(), 0.05);
}

TEST(AnyHeading, ImagesOfOtherPlacesAreRefused) {
  painted::Drive drive = painted::make_drive(10);
  for (size_t s = 0; s < drive.scenes.size() / 2; ++s) {
    std::swap(drive.scenes[s].image, drive.scenes[drive.scenes.size() - 1 - s].image);
  }
  const CalibrationResult result =
      calibrate_any_heading(drive.scenes, drive.cameras, drive.T_camera_lidar, screening_options());
  EXPECT_FALSE(result.usable());
  EXPECT_FALSE(result.reason.empty());
}

TEST(AnyHeading, OptionsSayWhatIsWrong) {
  EXPECT_FALSE(HeadingOptions{}.invalid());
  EXPECT_TRUE(HeadingOptions{.headings = 1}.invalid());
  EXPECT_TRUE((HeadingOptions{.headings = 6, .half_width = 0.2}).invalid()) << "gaps between them";
  EXPECT_TRUE(HeadingOptions{.verified = 0}.invalid());
  EXPECT_TRUE(HeadingOptions{.min_share = 2}.invalid());
  EXPECT_TRUE(HeadingOptions{.position_sigma = 0}.invalid());
}

}  // namespace
}  // namespace infuse::calibration
