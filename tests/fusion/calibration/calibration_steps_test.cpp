#include "fusion/calibration/calibration_steps.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

TEST(FineRestarts, ReturnToTheTruthFromWhereOneAscentMayStop) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const CalibrateOptions options{.fine_restarts = 6};
  CalibrationSteps steps(drive.scenes, drive.cameras, drive.T_camera_lidar, options);
  int found = 0;
  for (int axis = 0; axis < 6; ++axis) {
    geometry::Vector6 off = geometry::Vector6::Zero();
    off(axis) = axis < 3 ? options.fine_restart_rotation : options.fine_restart_translation;
    const auto end = steps.run_fine_restarts(geometry::exp(off) * drive.T_camera_lidar);
    if (!end) continue;  // none was higher than the ascent from there
    ++found;
    EXPECT_LT(painted::degrees_between(*end, drive.T_camera_lidar), 0.1) << axis;
    EXPECT_LT(painted::metres_between(*end, drive.T_camera_lidar), 0.03) << axis;
  }
  EXPECT_GT(found, 0);
}

TEST(FineRestarts, NoneAreRunIfNoneAreWanted) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const CalibrateOptions options{.fine_restarts = 0};
  CalibrationSteps steps(drive.scenes, drive.cameras, drive.T_camera_lidar, options);
  const int before = steps.evaluations();
  EXPECT_FALSE(steps.run_fine_restarts(drive.T_camera_lidar));
  EXPECT_EQ(steps.evaluations(), before);
}

}  // namespace
}  // namespace infuse::calibration
