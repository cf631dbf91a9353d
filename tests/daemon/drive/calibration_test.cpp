// A camera whose pose differs from the rig's is detected while driving, reported and re-estimated;
// a camera at its stated pose is left unchanged.

#include <gmock/gmock.h>

#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "tests/daemon/drive/calibration_drive.hpp"

namespace infuse::daemon {
namespace {

/// Turns the camera of drive.toml about its y axis.
void turn_camera(const std::filesystem::path& folder, double degrees) {
  auto drive = recording::Drive::open(folder);
  ASSERT_TRUE(drive);
  Eigen::Isometry3d& T = drive->description.rig.cameras[0].T_camera_lidar;
  T.linear() = geometry::rotation_exp({0, degrees * kDegree, 0}) * T.linear();
  ASSERT_TRUE(recording::write_drive_toml(folder, drive->description));
}

TEST(CalibrationDrive, ATurnedCameraIsDetectedAndAGoodOneIsNotChanged) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(make_online_drive(folder / "drive", 45, 5, ""));

  const auto good = run_replay(folder / "drive");
  ASSERT_TRUE(good) << good.error().message();
  const CalibrationHistory quiet = read_calibration_history(*good);
  EXPECT_THAT(quiet.states, testing::Contains("OK"));
  EXPECT_THAT(quiet.states, testing::Not(testing::Contains("CONFIRMED")));
  EXPECT_THAT(quiet.alerts, testing::Not(testing::Contains("front.drift_confirmed")));

  ASSERT_NO_FATAL_FAILURE(turn_camera(folder / "drive", 1.0));
  RunReplayOptions options;
  options.pipeline.calibration.supervisor.policy = monitoring::UpdatePolicy::kApply;
  const auto turned = run_replay(folder / "drive", options);
  ASSERT_TRUE(turned);
  const CalibrationHistory history = read_calibration_history(*turned);
  EXPECT_THAT(history.alerts, testing::Contains("front.drift_confirmed"));
  // The re-estimated calibration is applied and is nearer to the truth.
  EXPECT_THAT(history.states,
              testing::IsSupersetOf({"SUSPECTED", "RECALIBRATING", "RECALIBRATED"}));
  ASSERT_TRUE(history.last_report.contains("estimate"));
  const auto truth = recording::Drive::open(folder / "drive");
  Eigen::Matrix3d R;
  for (int i = 0; i < 9; ++i) {
    R(i / 3, i % 3) = history.last_report["T_camera_lidar"][static_cast<size_t>(i / 3 * 4 + i % 3)];
  }
  const Eigen::Matrix3d R_true = geometry::rotation_exp({0, -1.0 * kDegree, 0}) *
                                 truth->description.rig.cameras[0].T_camera_lidar.linear();
  const double rotation_error = geometry::rotation_log(R * R_true.transpose()).norm();
  EXPECT_LT(rotation_error, 0.5 * kDegree);
  options.rate = 200;
  EXPECT_EQ(run_replay(folder / "drive", options)->reports, turned->reports);
}

}  // namespace
}  // namespace infuse::daemon
