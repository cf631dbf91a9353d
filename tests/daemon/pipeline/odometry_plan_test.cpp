#include "daemon/pipeline/odometry_plan.hpp"

#include <gtest/gtest.h>

#include "daemon/pipeline/odometry_tracker.hpp"
#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::daemon {
namespace {

SensorSetup with_lidar(bool mounted) {
  SensorSetup setup;
  LidarMount lidar;
  if (mounted) lidar.T_vehicle_lidar.translation().z() = 1.7;
  setup.rig.lidars.push_back(lidar);
  return setup;
}

TEST(OdometryPlan, ALidarIsUsedWhereItCanBeRelatedToTheOtherSensors) {
  for (const bool mounted : {false, true}) {
    SensorSetup setup = with_lidar(mounted);
    EXPECT_TRUE(*plan_odometry({}, setup).use_lidar) << "nothing else measures the motion";
    setup.vehicle.speed.emplace();
    EXPECT_EQ(*plan_odometry({}, setup).use_lidar, mounted);
    EXPECT_FALSE(*plan_odometry({.use_lidar = false}, setup).use_lidar);
  }
  EXPECT_FALSE(*plan_odometry({.use_lidar = true}, SensorSetup()).use_lidar) << "there is none";
}

TEST(OdometryPlan, OnlyABusAloneIsPlanar) {
  SensorSetup bus;
  bus.vehicle.speed.emplace();
  EXPECT_TRUE(*plan_odometry({}, bus).planar);
  bus.vehicle.imu.emplace();
  EXPECT_FALSE(*plan_odometry({}, bus).planar);
  EXPECT_FALSE(*plan_odometry({}, with_lidar(true)).planar);
  EXPECT_TRUE(*plan_odometry({.planar = true}, bus).planar);
}

// The bias of a yaw rate that nothing checks turns the vehicle by as much as it is unsure.
TEST(OdometryTracker, SaysWhatABusAloneWantsAndThatItsHeadingIsLost) {
  const motion::TrueDrive drive = motion::town_drive(61);
  motion::SimulatedSensors sensors(drive, 1);
  OdometryTracker tracker{OdometrySettings()};
  double t = 0;
  for (const double until : {10.0, 60.0}) {
    for (; t < until; t += 0.02) tracker.add(sensors.wheels(t));
    PoseReport pose = tracker.pose_at(motion::seconds(until - 0.5));
    ASSERT_TRUE(pose.usable()) << pose.reason;
    tracker.bound(pose);
    EXPECT_EQ(pose.usable(), until < 30) << pose.reason;
  }
  EXPECT_NE(std::string(tracker.status(motion::seconds(59.5)).wanted).find("steering angle"),
            std::string::npos);
}

// It stands until 4 s, and is then carried straight on.
TEST(OdometryTracker, WhileWheelsRestALidarThatIsNotUsedOtherwiseMeasuresTheMotion) {
  constexpr double kEnd = 14, kSweep = 0.1, kStands = 4;
  const motion::TrueDrive drive(kEnd, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[3] = std::clamp(2 * (t - kStands), 0.0, 5.0);
    return twist;
  });
  motion::SimulatedSensors sensors(drive, 1);
  OdometryTracker tracker{OdometrySettings{.use_lidar = false}};
  for (int i = 1; kSweep * i < kEnd; ++i) {
    const double from = kSweep * (i - 1), to = kSweep * i;
    for (int k = 1; k <= 5; ++k) {
      WheelOdometry wheels = sensors.wheels(from + kSweep * k / 5);
      wheels.wheel_speed.fill(0);
      tracker.add(wheels);
    }
    ASSERT_TRUE(tracker.wants_lidar());
    tracker.mark(motion::seconds(to), true);
    tracker.process_until(motion::seconds(to));
    if (i > 1) tracker.add(sensors.lidar(from, to));
  }
  const double truth = drive.pose(kEnd - kSweep).translation().x();
  EXPECT_NEAR(tracker.predicted_pose().T_odom_vehicle.translation().x(), truth, 1);
  EXPECT_GT(truth, 40);
  WheelOdometry turning = sensors.wheels(1);
  turning.wheel_speed = {3, 3, 0, 0};
  tracker.add(turning);
  EXPECT_FALSE(tracker.wants_lidar());
}

}  // namespace
}  // namespace infuse::daemon
