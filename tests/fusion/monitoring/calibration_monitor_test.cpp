#include "fusion/monitoring/calibration_monitor.hpp"
#include "drivers/measurement/angles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fusion/monitoring/reestimate.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::monitoring {
namespace {

using calibration::painted::degrees_between;
using calibration::painted::metres_between;
using calibration::painted::small_camera;
using calibration::painted::true_T_camera_lidar;

/// Images and sweeps of ten places.
struct Snapshot {
  CameraFrame grey;
  Sweep sweep;
};

const std::vector<Snapshot>& snapshots() {
  static const std::vector<Snapshot> all = [] {
    std::vector<Snapshot> made;
    for (uint64_t k = 0; k < 10; ++k) {
      const auto world = calibration::painted::make_world(k + 1);
      made.push_back(
          {calibration::painted::render_image(world, small_camera(), true_T_camera_lidar()),
           calibration::painted::scan(world, 100 + k)});
    }
    return made;
  }();
  return all;
}

const Motion kDrivingMotion{.velocity = Eigen::Vector3d(0, 0, 8)};

Eigen::Isometry3d turned(double degrees, int axis) {
  return geometry::exp(degrees * kDegree * geometry::Vector6::Unit(axis)) * true_T_camera_lidar();
}

/// Drives past the places again and again, twice a second.
class Driver {
 public:
  MonitorReport drive(CalibrationMonitor& monitor, const Motion& motion = kDrivingMotion) {
    const Snapshot& place = snapshots()[static_cast<size_t>(next_) % snapshots().size()];
    CameraFrame grey = place.grey;
    // No two images are equal.
    grey.pixels[0] = static_cast<uint8_t>(next_);
    grey.pixels[1] = static_cast<uint8_t>(next_ / 256);
    grey.stamp = Stamp::from_ns(500'000'000LL * next_++);
    return monitor.process(grey, make_sweep_view(place.sweep), motion);
  }
  MonitorReport drive(CalibrationMonitor& monitor, int images) {
    MonitorReport report;
    for (int k = 0; k < images; ++k) report = drive(monitor);
    return report;
  }

 private:
  int next_ = 1;
};

TEST(CalibrationMonitor, AnUnchangedCalibrationHolds) {
  CalibrationMonitor monitor(small_camera(), true_T_camera_lidar(), {});
  Driver driver;
  const MonitorReport report = driver.drive(monitor, 200);
  EXPECT_EQ(report.verdict.drift, Drift::kHolds)
      << report.verdict.evidence << " " << name_of(report.verdict.axis);
  EXPECT_EQ(report.verdict.fault, CameraFault::kNone);
  EXPECT_LT(report.verdict.offset.head<3>().norm(), 0.2 * kDegree);
}

TEST(CalibrationMonitor, ARotatedCameraIsDetectedWithItsAxis) {
  for (int axis = 0; axis < 3; ++axis) {
    CalibrationMonitor monitor(small_camera(), turned(1, axis), {});
    Driver driver;
    const MonitorReport report = driver.drive(monitor, 60);
    EXPECT_EQ(report.verdict.drift, Drift::kConfirmed) << axis;
    EXPECT_GT(report.verdict.offset(axis), 0.2 * kDegree) << axis;
  }
}

TEST(CalibrationMonitor, TheAmountOfALargeDriftIsAnEstimate) {
  for (const double degrees : {0.8, 3.0}) {
    CalibrationMonitor monitor(small_camera(), turned(degrees, 1), {});
    Driver driver;
    const DriftVerdict verdict = driver.drive(monitor, 60).verdict;
    EXPECT_EQ(verdict.drift, Drift::kConfirmed) << degrees;
    EXPECT_EQ(verdict.axis, Axis::kRotationY) << degrees;
    EXPECT_NEAR(verdict.offset(1), degrees * kDegree, 3 * verdict.sigma(1)) << degrees;
    EXPECT_LT(verdict.sigma(1), 0.2 * kDegree) << degrees;
    EXPECT_FALSE(verdict.at_least) << degrees;
  }
}

TEST(CalibrationMonitor, TheCallerMayRunTheSearch) {
  MonitorOptions in_background;
  in_background.background_search = true;
  CalibrationMonitor alone(small_camera(), turned(3, 1), {});
  CalibrationMonitor monitor(small_camera(), turned(3, 1), in_background);
  Driver first, second;
  int searches = 0;
  for (int k = 0; k < 22; ++k) {
    const DriftVerdict expected = first.drive(alone).verdict;
    EXPECT_EQ(second.drive(monitor).verdict.evidence, expected.evidence) << k;
    if (!monitor.search_due()) continue;
    ++searches;
    monitor.begin_search();
    monitor.run_search();
    monitor.finish_search();
  }
  EXPECT_GE(searches, 1);
  EXPECT_EQ(second.drive(monitor).verdict.offset, first.drive(alone).verdict.offset);
}

TEST(CalibrationMonitor, ASearchUnderAnOlderCalibrationIsDropped) {
  MonitorOptions options;
  options.background_search = true;
  CalibrationMonitor monitor(small_camera(), turned(3, 1), options);
  Driver driver;
  for (int k = 0; k < 60 && !monitor.search_due(); ++k) driver.drive(monitor);
  ASSERT_TRUE(monitor.search_due());
  monitor.begin_search();
  monitor.run_search();
  monitor.set_calibration(true_T_camera_lidar());
  monitor.finish_search();
  EXPECT_FALSE(driver.drive(monitor).verdict.drifting());
}

TEST(CalibrationMonitor, ANewCalibrationResetsTheEvidence) {
  CalibrationMonitor monitor(small_camera(), turned(1, 1), {});
  Driver driver;
  EXPECT_EQ(driver.drive(monitor, 60).verdict.drift, Drift::kConfirmed);
  monitor.set_calibration(true_T_camera_lidar());
  EXPECT_NE(driver.drive(monitor, 1).verdict.drift, Drift::kConfirmed);
  EXPECT_EQ(driver.drive(monitor, 60).verdict.drift, Drift::kHolds);
}

TEST(CalibrationMonitor, TheAlternativeIsComparedWithTheCurrent) {
  CalibrationMonitor monitor(small_camera(), true_T_camera_lidar(), {});
  monitor.set_alternative(turned(1, 0));
  Driver driver;
  double gain = 0;
  for (int k = 0; k < 10; ++k) {
    const MonitorReport report = driver.drive(monitor);
    ASSERT_TRUE(report.has_gain);
    gain += report.gain;
  }
  EXPECT_GT(gain, 0);
}

TEST(CalibrationMonitor, AStandingVehicleIsEvaluatedOnce) {
  CalibrationMonitor monitor(small_camera(), true_T_camera_lidar(), {});
  Driver driver;
  EXPECT_TRUE(driver.drive(monitor, Motion{}).evaluated);
  for (int k = 0; k < 20; ++k) {
    const MonitorReport report = driver.drive(monitor, Motion{});
    EXPECT_FALSE(report.evaluated);
    EXPECT_THAT(report.reason, testing::HasSubstr("same place"));
  }
}

TEST(CalibrationMonitor, WrongImagesAndEmptySweepsAreSkipped) {
  CalibrationMonitor monitor(small_camera(), true_T_camera_lidar(), {});
  EXPECT_FALSE(monitor.process(CameraFrame{}, make_sweep_view(Sweep{}), kDrivingMotion).evaluated);
  CameraFrame grey = snapshots()[0].grey;
  EXPECT_THAT(monitor.process(grey, make_sweep_view(Sweep{}), kDrivingMotion).reason,
              testing::HasSubstr("too few"));
}

TEST(CalibrationMonitor, AllocatesNothingOnceWarm) {
  MonitorOptions options;
  options.scene_store.capacity = 4;
  CalibrationMonitor monitor(small_camera(), true_T_camera_lidar(), options);
  Driver driver;
  driver.drive(monitor, 30);
  const Snapshot& place = snapshots()[3];
  CameraFrame grey = place.grey;
  grey.stamp = Stamp::from_ns(100'000'000'000);
  const size_t before = allocation_count();
  const MonitorReport report = monitor.process(grey, make_sweep_view(place.sweep), kDrivingMotion);
  const size_t after = allocation_count();
  EXPECT_TRUE(report.evaluated);
  EXPECT_EQ(after, before);
}

TEST(CalibrationMonitor, TheSameInputGivesTheSameReports) {
  CalibrationMonitor a(small_camera(), turned(0.4, 2), {});
  CalibrationMonitor b(small_camera(), turned(0.4, 2), {});
  Driver first, second;
  for (int k = 0; k < 20; ++k) {
    const MonitorReport x = first.drive(a);
    const MonitorReport y = second.drive(b);
    EXPECT_EQ(x.verdict.evidence, y.verdict.evidence);
    EXPECT_EQ(x.verdict.offset, y.verdict.offset);
    EXPECT_EQ(x.dependence, y.dependence);
  }
}

TEST(Reestimate, CorrectsARotatedCamera) {
  MonitorOptions options;
  options.scene_store.capacity = 10;
  CalibrationMonitor monitor(small_camera(), turned(1, 1), options);
  Driver driver;
  driver.drive(monitor, 30);
  const auto scenes = monitor.scenes().lend(Stamp::earliest());
  ASSERT_EQ(scenes.size(), 10U);
  const Reestimate result = reestimate(scenes, small_camera(), monitor.T_camera_lidar(), {});
  EXPECT_TRUE(result.usable()) << result.reason << ", " << result.split_half_distance;
  EXPECT_LT(degrees_between(result.T_camera_lidar, true_T_camera_lidar()), 0.15);
  EXPECT_LT(metres_between(result.T_camera_lidar, true_T_camera_lidar()), 0.03);
  EXPECT_GT(result.moved, 3.5);
  const Reestimate again = reestimate(scenes, small_camera(), monitor.T_camera_lidar(), {});
  EXPECT_EQ(again.T_camera_lidar.matrix(), result.T_camera_lidar.matrix());
}

TEST(Reestimate, ReducedImagesCorrectItToo) {
  CameraIntrinsics large = small_camera();
  for (int* size : {&large.width, &large.height}) *size *= 2;
  for (double* of : {&large.fx, &large.fy, &large.cx, &large.cy}) *of *= 2;
  MonitorOptions options;
  options.scene_store = {.capacity = 10, .max_pixels = large.width * large.height / 4};
  CalibrationMonitor monitor(large, turned(1, 1), options);
  for (uint64_t k = 0; k < 10; ++k) {
    const auto world = calibration::painted::make_world(k + 1);
    CameraFrame grey = calibration::painted::render_image(world, large, true_T_camera_lidar());
    grey.stamp = Stamp::from_ns(1'000'000'000LL * static_cast<int64_t>(k + 1));
    const Sweep sweep = calibration::painted::scan(world, 100 + k);
    monitor.process(grey, make_sweep_view(sweep), {.velocity = Eigen::Vector3d(0, 0, 10)});
  }
  const auto scenes = monitor.scenes().lend(Stamp::earliest());
  ASSERT_GE(scenes.size(), 9U);
  EXPECT_EQ(scenes.front()->step, 2);
  const Reestimate result = reestimate(scenes, large, monitor.T_camera_lidar(), {});
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_LT(degrees_between(result.T_camera_lidar, true_T_camera_lidar()), 0.15);
}

TEST(Reestimate, TwoScenesAreRejected) {
  CalibrationMonitor monitor(small_camera(), true_T_camera_lidar(), {});
  Driver driver;
  driver.drive(monitor, 2);
  const auto scenes = monitor.scenes().lend(Stamp::earliest());
  const Reestimate result = reestimate(scenes, small_camera(), monitor.T_camera_lidar(), {});
  EXPECT_FALSE(result.usable());
  EXPECT_EQ(result.T_camera_lidar.matrix(), monitor.T_camera_lidar().matrix());
}

TEST(MonitorOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(MonitorOptions{}.invalid());
  EXPECT_TRUE(MonitorOptions{.rotation_step = 0}.invalid());
  EXPECT_TRUE(MonitorOptions{.max_points = 10}.invalid());
  MonitorOptions options;
  options.scene_store.capacity = 1;
  EXPECT_THAT(*options.invalid(), testing::HasSubstr("store"));
  EXPECT_FALSE(ReestimateOptions{}.invalid());
  EXPECT_TRUE(ReestimateOptions{.searches = 0}.invalid());
}

}  // namespace
}  // namespace infuse::monitoring
