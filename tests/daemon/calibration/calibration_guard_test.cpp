#include "daemon/calibration/calibration_guard.hpp"
#include "tests/stamp_at.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using monitoring::CalibrationState;

/// A guard of one camera that sees black images and no returns, ten times a second.
class CalibrationGuardTest : public testing::Test {
 protected:
  static CameraMount mount() {
    CameraMount mount;
    mount.name = "front";
    mount.intrinsics.width = 64;
    mount.intrinsics.height = 48;
    mount.intrinsics.fx = mount.intrinsics.fy = 40;
    mount.intrinsics.cx = 31.5;
    mount.intrinsics.cy = 23.5;
    mount.T_camera_lidar.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    return mount;
  }

  const CalibrationReport* process(double seconds, uint8_t grey = 0) {
    CameraFrame frame;
    frame.stamp = at(seconds);
    frame.width = 64;
    frame.height = 48;
    frame.pixels.assign(size_t{64} * 48, grey);
    return guard_.process(frame, {}, {});
  }

  CalibrationSettings settings_;
  CalibrationGuard guard_{mount(), settings_, true};
};

TEST_F(CalibrationGuardTest, ReportsTheFirstImageThenEveryTenSeconds) {
  const CalibrationReport* first = process(0, 128);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->camera, "front");
  EXPECT_EQ(first->state, CalibrationState::kMonitoring);
  EXPECT_EQ(first->since, at(0));
  EXPECT_EQ(first->verdict.drift, monitoring::Drift::kLearning);
  EXPECT_FALSE(first->estimate);
  int reports = 0;
  for (int i = 1; i <= 200; ++i) {  // grey that changes: neither black nor frozen
    reports += process(0.1 * i, static_cast<uint8_t>(100 + i % 50)) != nullptr ? 1 : 0;
  }
  EXPECT_EQ(reports, 2);
}

TEST_F(CalibrationGuardTest, ABlackImageMakesTheCalibrationUnusableAtOnce) {
  CalibrationReport last;
  for (int i = 0; i < 50; ++i) {
    if (const CalibrationReport* report = process(0.1 * i)) last = *report;
  }
  EXPECT_EQ(last.state, CalibrationState::kUnusable);
  EXPECT_EQ(last.verdict.fault, monitoring::CameraFault::kBlack);
  EXPECT_FALSE(last.history.empty());
}

TEST_F(CalibrationGuardTest, AFreezeTakesEffectWithTheNextImage) {
  process(0, 128);
  guard_.handle_request({.op = Request::Op::kFreeze, .on = true});
  process(0.1, 129);
  const CalibrationReport* report = process(10, 130);
  ASSERT_NE(report, nullptr);
  EXPECT_TRUE(report->frozen);
  guard_.handle_request({.op = Request::Op::kFreeze, .on = false});
  report = process(20, 131);
  ASSERT_NE(report, nullptr);
  EXPECT_FALSE(report->frozen);
}

TEST_F(CalibrationGuardTest, TheCalibrationInUseIsTheConfiguredOneUntilAnotherIsApplied) {
  process(0, 128);
  guard_.handle_request({.op = Request::Op::kApply});
  guard_.handle_request({.op = Request::Op::kRollback});
  process(0.1, 129);
  EXPECT_TRUE(guard_.T_camera_lidar().isApprox(mount().T_camera_lidar));
  guard_.shut_down();
}

}  // namespace
}  // namespace infuse::daemon
