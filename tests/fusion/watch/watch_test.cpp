#include "fusion/watch/watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fusion/watch/reestimate.hpp"
#include "tests/fusion/calibration/painted_world.hpp"
#include "tests/fusion/motion/allocation_counter.hpp"

namespace infuse::watch {
namespace {

using calibration::painted::degrees_between;
using calibration::painted::metres_between;
using calibration::painted::small_camera;
using calibration::painted::true_T_camera_lidar;

/// What a vehicle sees at ten places.
struct Place {
  CameraFrame grey;
  Sweep sweep;
};

const std::vector<Place>& places() {
  static const std::vector<Place> all = [] {
    std::vector<Place> made;
    for (uint64_t k = 0; k < 10; ++k) {
      const auto world = calibration::painted::make_world(k + 1);
      made.push_back(
          {calibration::painted::photograph(world, small_camera(), true_T_camera_lidar()),
           calibration::painted::scan(world, 100 + k)});
    }
    return made;
  }();
  return all;
}

const Motion kDriving{.velocity = Eigen::Vector3d(0, 0, 8)};

Eigen::Isometry3d turned(double degrees, int axis) {
  return geometry::exp(degrees * M_PI / 180 * geometry::Vector6::Unit(axis)) *
         true_T_camera_lidar();
}

/// Drives past the places again and again, twice a second.
class Driver {
 public:
  WatchReport drive(Watch& watch, const Motion& motion = kDriving) {
    const Place& place = places()[static_cast<size_t>(next_) % places().size()];
    CameraFrame grey = place.grey;
    // No two pictures are equal.
    grey.pixels[0] = static_cast<uint8_t>(next_);
    grey.pixels[1] = static_cast<uint8_t>(next_ / 256);
    grey.stamp = Stamp::from_ns(500'000'000LL * next_++);
    return watch.take(grey, view_of(place.sweep), motion);
  }
  WatchReport drive(Watch& watch, int pictures) {
    WatchReport report;
    for (int k = 0; k < pictures; ++k) report = drive(watch);
    return report;
  }

 private:
  int next_ = 1;
};

TEST(Watch, AKeptCalibrationHolds) {
  Watch watch(small_camera(), true_T_camera_lidar(), {});
  Driver driver;
  const WatchReport report = driver.drive(watch, 200);
  EXPECT_EQ(report.drift, Drift::kHolds) << report.evidence << " " << to_string(report.axis);
  EXPECT_EQ(report.fault, CameraFault::kNone);
  EXPECT_LT(report.offset.head<3>().norm(), 0.2 * M_PI / 180);
}

TEST(Watch, ATurnedCameraIsNoticedAndItsAxisNamed) {
  for (int axis = 0; axis < 3; ++axis) {
    Watch watch(small_camera(), turned(1, axis), {});
    Driver driver;
    const WatchReport report = driver.drive(watch, 60);
    EXPECT_EQ(report.drift, Drift::kDrifted) << axis;
    EXPECT_GT(report.offset(axis), 0.2 * M_PI / 180) << axis;
  }
}

TEST(Watch, ANewCalibrationStartsAnew) {
  Watch watch(small_camera(), turned(1, 1), {});
  Driver driver;
  EXPECT_EQ(driver.drive(watch, 60).drift, Drift::kDrifted);
  watch.set_calibration(true_T_camera_lidar());
  EXPECT_NE(driver.drive(watch, 1).drift, Drift::kDrifted);
  EXPECT_EQ(driver.drive(watch, 60).drift, Drift::kHolds);
}

TEST(Watch, TheAlternativeIsComparedWithThePresent) {
  Watch watch(small_camera(), true_T_camera_lidar(), {});
  watch.set_alternative(turned(1, 0));
  Driver driver;
  double gain = 0;
  for (int k = 0; k < 10; ++k) {
    const WatchReport report = driver.drive(watch);
    ASSERT_TRUE(report.has_gain);
    gain += report.gain;
  }
  EXPECT_GT(gain, 0);
}

TEST(Watch, AStandingVehicleLooksOnce) {
  Watch watch(small_camera(), true_T_camera_lidar(), {});
  Driver driver;
  EXPECT_TRUE(driver.drive(watch, Motion{}).looked);
  for (int k = 0; k < 20; ++k) {
    const WatchReport report = driver.drive(watch, Motion{});
    EXPECT_FALSE(report.looked);
    EXPECT_THAT(report.reason, testing::HasSubstr("same place"));
  }
}

TEST(Watch, WrongPicturesAndEmptySweepsArePassedOver) {
  Watch watch(small_camera(), true_T_camera_lidar(), {});
  EXPECT_FALSE(watch.take(CameraFrame{}, view_of(Sweep{}), kDriving).looked);
  CameraFrame grey = places()[0].grey;
  EXPECT_THAT(watch.take(grey, view_of(Sweep{}), kDriving).reason, testing::HasSubstr("too few"));
}

TEST(Watch, AllocatesNothingOnceWarm) {
  WatchOptions options;
  options.store.capacity = 4;
  Watch watch(small_camera(), true_T_camera_lidar(), options);
  Driver driver;
  driver.drive(watch, 30);
  const Place& place = places()[3];
  CameraFrame grey = place.grey;
  grey.stamp = Stamp::from_ns(100'000'000'000);
  const size_t before = motion::allocations();
  const WatchReport report = watch.take(grey, view_of(place.sweep), kDriving);
  const size_t after = motion::allocations();
  EXPECT_TRUE(report.looked);
  EXPECT_EQ(after, before);
}

TEST(Watch, SameInSameOut) {
  Watch a(small_camera(), turned(0.4, 2), {});
  Watch b(small_camera(), turned(0.4, 2), {});
  Driver first, second;
  for (int k = 0; k < 20; ++k) {
    const WatchReport x = first.drive(a);
    const WatchReport y = second.drive(b);
    EXPECT_EQ(x.evidence, y.evidence);
    EXPECT_EQ(x.offset, y.offset);
    EXPECT_EQ(x.dependence, y.dependence);
  }
}

TEST(Reestimate, BringsATurnedCameraHome) {
  WatchOptions options;
  options.store.capacity = 10;
  Watch watch(small_camera(), turned(1, 1), options);
  Driver driver;
  driver.drive(watch, 30);
  std::vector<StoredScene> scenes;
  watch.scenes().copy(Stamp::earliest(), scenes);
  ASSERT_EQ(scenes.size(), 10U);
  const Reestimate result = reestimate(scenes, small_camera(), watch.T_camera_lidar(), {});
  EXPECT_TRUE(result.usable()) << result.reason << ", " << result.split;
  EXPECT_LT(degrees_between(result.T_camera_lidar, true_T_camera_lidar()), 0.15);
  EXPECT_LT(metres_between(result.T_camera_lidar, true_T_camera_lidar()), 0.03);
  EXPECT_GT(result.moved, 3.5);
  const Reestimate again = reestimate(scenes, small_camera(), watch.T_camera_lidar(), {});
  EXPECT_EQ(again.T_camera_lidar.matrix(), result.T_camera_lidar.matrix());
}

TEST(Reestimate, TwoScenesAreRefused) {
  Watch watch(small_camera(), true_T_camera_lidar(), {});
  Driver driver;
  driver.drive(watch, 2);
  std::vector<StoredScene> scenes;
  watch.scenes().copy(Stamp::earliest(), scenes);
  const Reestimate result = reestimate(scenes, small_camera(), watch.T_camera_lidar(), {});
  EXPECT_FALSE(result.usable());
  EXPECT_EQ(result.T_camera_lidar.matrix(), watch.T_camera_lidar().matrix());
}

TEST(WatchOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(WatchOptions{}.invalid());
  EXPECT_TRUE(WatchOptions{.rotation_step = 0}.invalid());
  EXPECT_TRUE(WatchOptions{.max_points = 10}.invalid());
  WatchOptions options;
  options.store.capacity = 1;
  EXPECT_THAT(*options.invalid(), testing::HasSubstr("store"));
  EXPECT_FALSE(ReestimateOptions{}.invalid());
  EXPECT_TRUE(ReestimateOptions{.starts = 0}.invalid());
}

}  // namespace
}  // namespace infuse::watch
