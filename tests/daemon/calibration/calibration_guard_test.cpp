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

TEST_F(CalibrationGuardTest, CommandsTakeEffectAtOnceAlsoWithoutImages) {
  using Kind = CalibrationCommand::Kind;
  const CalibrationReport* report =
      guard_.handle({.kind = Kind::kFreeze, .camera = "front"}, at(0));
  ASSERT_NE(report, nullptr);
  EXPECT_TRUE(report->frozen);
  EXPECT_FALSE(
      guard_.handle({.kind = Kind::kFreeze, .camera = "front", .frozen = false}, at(1))->frozen);
  EXPECT_TRUE(guard_.handle({.kind = Kind::kRecalibrate, .camera = "front"}, at(1))
                  ->recalibration_requested);
  CalibrationCommand use{.camera = "front", .decision = 7};
  use.calibration.T_camera_lidar = mount().T_camera_lidar;
  use.calibration.T_camera_lidar.translation().x() = 0.1;
  report = guard_.handle(use, at(2));
  EXPECT_EQ(report->decision, 7U);
  EXPECT_EQ(report->state, CalibrationState::kRecalibrated);
  EXPECT_EQ(report->since, at(2));
  EXPECT_EQ(guard_.T_camera_lidar().translation().x(), 0.1);
  EXPECT_EQ(guard_.report_if_due(at(11)), nullptr);
  EXPECT_NE(guard_.report_if_due(at(12)), nullptr);
  EXPECT_EQ(guard_.report_at_end(at(13)), nullptr);  // nothing was evaluated since
  guard_.shut_down();
}

}  // namespace
}  // namespace infuse::daemon
