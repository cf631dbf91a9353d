// Errors of the sources that last: they are estimated, with their uncertainty, not rejected.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

#include "drivers/measurement/angles.hpp"
#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::motion {
namespace {

constexpr double kTurnOfLidar = 0.1;  // s

/// A town with crossings: it turns and brakes as cars do.
TrueDrive crossings(double length) {
  return TrueDrive(length, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = 0.35 * std::pow(std::sin(0.35 * t), 3);
    twist[3] = 9 + 4 * std::sin(0.5 * t);
    return twist;
  });
}

uint64_t rejected_courses(const OdometryFilter& filter) {
  return filter.report().sources[static_cast<size_t>(OdometrySource::kGnssCourse)].rejected;
}

// At any rate of the samples, between which the last one holds, and of two sensors that are late by
// the same: once the error of one made the other seem late, and both seemed 50 ms later.
TEST(SlowErrors, DelaysAreFoundByTheLidarsMotion) {
  constexpr double kDelay = 0.07;  // s
  const TrueDrive drive = crossings(46);
  for (const double interval : {0.1, 0.01}) {
    for (const auto& [bus, unit] : {std::pair(false, true), {true, false}, {true, true}}) {
      SimulatedSensors sensors(drive, 1);
      OdometryOptions options;
      options.planar = false;
      OdometryFilter filter(options);
      double next = 0;
      for (int i = 1; i < 450; ++i) {
        const double t = kTurnOfLidar * i;
        for (; next < t + 1e-9; next += interval) {
          const double measured = std::max(0.0, next - kDelay);
          ImuSample gyro = sensors.gyro(measured, {0.001, 0, 0.003});
          WheelOdometry wheels = sensors.wheels(next);
          wheels.yaw_rate = bus ? sensors.wheels(measured).yaw_rate : std::nan("");
          gyro.stamp = wheels.stamp;
          filter.add(wheels);
          if (unit) filter.add(gyro);
        }
        const RelativePose pose = sensors.lidar(t - kTurnOfLidar, t);
        add_sweep(filter, t, i > 1 ? &pose : nullptr);
      }
      const OdometryReport report = filter.report();
      for (const auto& [is_used, found] :
           {std::pair(bus, report.yaw_rate_delay), {unit, report.imu_delay}}) {
        if (!is_used) continue;
        EXPECT_NEAR(found.value, kDelay, 0.015) << interval << " " << bus << " " << unit;
        EXPECT_LT(std::abs(found.value - kDelay), 3 * found.sigma);
      }
      EXPECT_LT(report.sources[static_cast<size_t>(OdometrySource::kLidar)].rejected, 3U);
    }
  }
}

/// What the wheels measure; at rest they are exactly at rest.
WheelOdometry wheels_of(const TrueDrive& drive, SimulatedSensors& sensors, double t,
                        double yaw_bias) {
  WheelOdometry wheels = sensors.wheels(t, 1, yaw_bias);
  if (drive.twist(t)[3] == 0) wheels.wheel_speed.fill(0);
  return wheels;
}

/// Straight on; brakes from 13 s on by 6 m/s² to a stop.
TrueDrive straight_then_stop() {
  return TrueDrive(20, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = t < 13 ? 0.06 * std::sin(0.7 * t) : 0;
    twist[3] = std::clamp(9 - 6 * (t - 15), 0.0, 9.0);
    return twist;
  });
}

// Wheels that lock, slip or spin change their speed at once: no vehicle moves like that. One that
// brakes to a stop stands.
TEST(SlowErrors, WheelsThatJumpAreNotBelieved) {
  const TrueDrive drive = straight_then_stop();
  for (const double factor : {0.0, 0.7, 1.3, 2.0}) {
    SimulatedSensors sensors(drive, 4);
    OdometryFilter filter;
    for (int i = 0; i < 1000; ++i) {
      const double t = 0.02 * i;
      WheelOdometry wheels = wheels_of(drive, sensors, t, 0.002);
      for (double& speed : wheels.wheel_speed) speed *= t > 10 && t < 12 ? factor : 1;
      filter.add(wheels);
      const OdometryReport report = filter.report();
      if (t > 10.05 && t < 12.05) {
        EXPECT_FALSE(report.standing) << t;
        EXPECT_TRUE(!filter.usable() || std::abs(report.speed - 9) < 0.5)
            << factor << " at " << t << ": " << report.speed;
      }
      if (t > 12.3 && t < 14.9) {
        ASSERT_TRUE(filter.usable()) << factor << " at " << t << ": " << filter.reason();
        EXPECT_NEAR(report.speed, 9, 0.5) << factor << " at " << t;
      }
    }
    EXPECT_TRUE(filter.report().standing) << factor;
    EXPECT_NEAR(filter.report().yaw_rate_bias.value, 0.002, 0.001) << factor;
  }
}

// For longer than a vehicle slides on ice: what stands still is the wheels, not the vehicle.
TEST(SlowErrors, LockedWheelsAreNotBelievedUntilTheyTurn) {
  const TrueDrive drive(34, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = 0.06 * std::sin(0.7 * t);
    twist[3] = 9 + 2 * std::sin(0.3 * t);
    return twist;
  });
  for (const double seconds : {0.5, 2.0, 15.0}) {
    SimulatedSensors sensors(drive, 6);
    OdometryFilter filter;
    const auto rejected = [&] {
      return filter.report().sources[static_cast<size_t>(OdometrySource::kWheels)].rejected;
    };
    for (int i = 0; i < 1650; ++i) {
      const double t = 0.02 * i;
      const bool locked = t > 10 && t < 10 + seconds;
      WheelOdometry wheels = sensors.wheels(t, 1, 0.002);
      if (locked) wheels.wheel_speed.fill(0);
      filter.add(wheels);
      EXPECT_FALSE(filter.report().standing) << seconds << " at " << t;
      if (locked && t > 10.6) {
        EXPECT_FALSE(filter.usable()) << seconds << " at " << t;
      }
      if (t > 10 + seconds + 0.6) {
        ASSERT_TRUE(filter.usable()) << seconds << " at " << t << ": " << filter.reason();
        EXPECT_NEAR(filter.report().speed, drive.twist(t)[3], 0.5) << seconds << " at " << t;
      }
    }
    EXPECT_GT(static_cast<double>(rejected()), 0.9 * seconds / 0.02) << "an alert names them";
  }
}

// The others carry on, and the source is known to contradict itself.
TEST(SlowErrors, SomeWheelsThatLieAreCounted) {
  const TrueDrive drive = straight_then_stop();
  for (const size_t lying : {size_t{1}, size_t{2}}) {
    SimulatedSensors sensors(drive, 4);
    OdometryFilter filter;
    const auto wheels_record = [&] {
      return filter.report().sources[static_cast<size_t>(OdometrySource::kWheels)];
    };
    SourceRecord before;
    for (int i = 0; i < 600; ++i) {
      const double t = 0.02 * i;
      WheelOdometry wheels = wheels_of(drive, sensors, t, 0.002);
      for (size_t k = 0; t > 8 && k < lying; ++k) wheels.wheel_speed[k] *= 1.5;
      if (i == 400) before = wheels_record();
      filter.add(wheels);
      EXPECT_TRUE(t < 1 || std::abs(filter.report().speed - 9) < 0.3) << t;
    }
    EXPECT_LT(before.rejected, 5U);
    EXPECT_GT(wheels_record().rejected, before.rejected + 190);
    EXPECT_TRUE(filter.usable());
  }
}

// A vehicle that is carried turns while its wheels rest: that is no bias of its gyros.
TEST(SlowErrors, ATurnAtRestIsNotLearnedAsABias) {
  const TrueDrive drive(40, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = t > 20 ? 3 * kDegree : 0;
    twist[3] = std::clamp(5 - 2 * (t - 5), 0.0, 5.0);
    return twist;
  });
  SimulatedSensors sensors(drive, 5);
  OdometryFilter filter;
  for (int i = 0; i < 1900; ++i) filter.add(wheels_of(drive, sensors, 0.02 * i, 0.003));
  EXPECT_NEAR(filter.report().yaw_rate_bias.value, 0.003, 0.001);
}

// Wheels that were out while the vehicle was carried measure its speed again once it drives.
TEST(SlowErrors, WheelsMeasureAgainAfterTheVehicleWasCarried) {
  const TrueDrive drive(40, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = t > 5 && t < 10 ? 10 * kDegree : 0;
    twist[3] = std::clamp(2 * (t - 15), 0.0, 8.0);
    return twist;
  });
  SimulatedSensors sensors(drive, 5);
  OdometryOptions options;
  options.planar = false;
  OdometryFilter filter(options);
  bool was_out = false;
  for (int i = 0; i < 1900; ++i) {
    const double t = 0.02 * i;
    filter.add(wheels_of(drive, sensors, t, 0));
    filter.add(sensors.gyro(t, {0, 0, 0}));
    was_out = was_out || (t > 6 && t < 10 && !filter.wheels_measure_motion());
  }
  EXPECT_TRUE(was_out);
  EXPECT_TRUE(filter.wheels_measure_motion());
}

// The course of a receiver beside the axle, in bends, is not the heading, and it is late.
TEST(SlowErrors, ACourseThatSlipsLeavesTheHeading) {
  constexpr double kSideSlip = 0.006, kLever = 1.0, kDelay = 0.15;  // rad per m/s², m, s
  const TrueDrive drive = crossings(61);
  std::array<double, 2> errors{};
  for (const bool gnss : {false, true}) {
    SimulatedSensors sensors(drive, 3);
    OdometryOptions options;
    options.planar = false;
    options.east_heading_sigma = 10;
    options.gnss_delay = Duration::zero();
    OdometryFilter filter(options);
    for (int i = 1; i < 600; ++i) {
      const double t = kTurnOfLidar * i;
      for (double s = t - kTurnOfLidar + 0.02; s < t + 1e-9; s += 0.02) {
        filter.add(sensors.gyro(s, {0.001, 0, 0.003}));
      }
      if (gnss) {
        const double s = std::max(0.0, t - kDelay);
        GnssFix fix = sensors.gnss(s);
        fix.stamp = seconds(t);
        const geometry::Vector6 twist = drive.twist(s);
        fix.course -= kSideSlip * twist[2] * twist[3] + kLever * twist[2] / twist[3];
        filter.add(fix);
      }
      const RelativePose pose = sensors.lidar(t - kTurnOfLidar, t);
      add_sweep(filter, t, i > 1 ? &pose : nullptr);
    }
    EXPECT_LT(rejected_courses(filter), 3U);
    const auto motion = filter.trajectory().between(seconds(1), seconds(59));
    const Eigen::Matrix3d truth = drive.pose(1).linear().transpose() * drive.pose(59).linear();
    const double error = geometry::rotation_log(truth.transpose() * motion.T_from_to.linear()).z();
    errors[gnss] = std::abs(error);
  }
  EXPECT_LT(errors[1], errors[0] + 0.1 * kDegree) << "a receiver does not make the heading worse";
}

double heading_error(const TrueDrive& drive, const OdometryFilter& filter, double t) {
  const Eigen::Matrix3d truth = drive.pose(t).linear();
  const geometry::PoseAt now = filter.predicted_pose();
  return geometry::rotation_log(truth.transpose() * now.T_odom_vehicle.linear()).z();
}

// Nothing but the course shows how late the gyro is, and it may be late itself.
TEST(SlowErrors, AHeadingByALateGyroAndACourseIsWithinItsSigma) {
  constexpr double kDelay = 0.07;  // s
  const TrueDrive drive = crossings(61);
  for (const uint64_t seed : {1U, 2U, 3U}) {
    SimulatedSensors sensors(drive, seed);
    OdometryFilter filter;
    for (int i = 1; i < 3000; ++i) {
      const double t = 0.02 * i;
      ImuSample gyro = sensors.gyro(std::max(0.0, t - kDelay), {0, 0, 0.003});
      gyro.stamp = seconds(t);
      WheelOdometry wheels = sensors.wheels(t);
      wheels.yaw_rate = std::nan("");
      filter.add(wheels);
      filter.add(gyro);
      if (i % 5 == 0) filter.add(sensors.gnss(t));
      filter.process_until(seconds(t));
      const double sigma = std::sqrt(filter.predicted_pose().covariance(2, 2));
      ASSERT_TRUE(t < 2 || std::abs(heading_error(drive, filter, t)) < 3 * sigma)
          << seed << " at " << t;
    }
    EXPECT_LT(rejected_courses(filter), 3U);
  }
}

// The gyro is 70 ms late, then by more than is sought, then, without a lidar, not at all.
TEST(SlowErrors, ADelayThatWasRefutedIsNotUsed) {
  const TrueDrive drive = crossings(300);
  SimulatedSensors sensors(drive, 1);
  OdometryOptions options;
  options.planar = false;
  OdometryFilter filter(options);
  const auto add = [&](int sweep, double late, bool lidar) {
    const double t = kTurnOfLidar * sweep;
    for (double s = t - kTurnOfLidar + 0.02; s < t + 1e-9; s += 0.02) {
      ImuSample gyro = sensors.gyro(std::max(0.0, s - late), {0, 0, 0.003});
      WheelOdometry wheels = sensors.wheels(s);
      wheels.yaw_rate = std::nan("");
      gyro.stamp = wheels.stamp;
      filter.add(wheels);
      filter.add(gyro);
    }
    const RelativePose pose = sensors.lidar(t - kTurnOfLidar, t);
    add_sweep(filter, t, lidar && sweep > 1 ? &pose : nullptr);
  };
  int i = 1;
  for (; i < 450; ++i) add(i, 0.07, true);
  ASSERT_NEAR(filter.report().imu_delay.value, 0.07, 0.015);
  for (; i < 2500 && filter.report().imu_delay.value != 0; ++i) add(i, 0.4, true);
  ASSERT_EQ(filter.report().imu_delay.value, 0) << "refuted";
  ASSERT_EQ(filter.report().imu_delay.sigma, options.imu_delay_sigma);
  const double from = kTurnOfLidar * (i - 1);
  for (int sweep = 0; sweep < 90; ++sweep) add(i++, 0, false);
  for (double to = from + 0.5; to < from + 8; to += 0.5) {
    const auto motion = filter.trajectory().between(seconds(from), seconds(to));
    const Eigen::Matrix3d truth = drive.pose(from).linear().transpose() * drive.pose(to).linear();
    const double error = geometry::rotation_log(truth.transpose() * motion.T_from_to.linear()).z();
    EXPECT_LT(std::abs(error), 0.3 * kDegree) << to - from;
  }
}

/// Wheels, a gyro with a bias of 0.003 rad/s, and from 30 s on a course that is `turned`.
void drive_by_course(OdometryFilter& filter, SimulatedSensors& sensors, double from, double to,
                     double turned) {
  for (int i = static_cast<int>(50 * from) + 1; i <= 50 * to; ++i) {
    const double t = 0.02 * i;
    WheelOdometry wheels = sensors.wheels(t);
    wheels.yaw_rate = std::nan("");
    filter.add(wheels);
    filter.add(sensors.gyro(t, {0, 0, 0.003}));
    if (i % 5 != 0) continue;
    GnssFix fix = sensors.gnss(t);
    fix.course -= t > 30 ? turned : 0;
    filter.add(fix);
  }
}

// A heading that is surely wrong contradicts courses, once the gyro's bias does not explain them.
TEST(SlowErrors, CoursesAreBelievedAgainBesideAWrongHeading) {
  const TrueDrive drive = crossings(111);
  SimulatedSensors sensors(drive, 1);
  OdometryFilter filter;
  Eigen::Isometry3d wrong = Eigen::Isometry3d::Identity();
  wrong.linear() = geometry::rotation_exp({0, 0, 8 * kDegree});
  filter.set_pose(wrong, 1e-8 * geometry::Matrix6::Identity());
  drive_by_course(filter, sensors, 0, 80, 0);
  const uint64_t rejected = rejected_courses(filter);
  EXPECT_GT(rejected, 500U);
  drive_by_course(filter, sensors, 80, 110, 0);
  EXPECT_LT(rejected_courses(filter), rejected + 3);
  EXPECT_NEAR(filter.report().gyro_bias[2].value, 0.003, 0.002);
}

// The frame does not point where it was thought to: the path does not turn.
TEST(SlowErrors, CoursesThatTurnForGoodAreBelievedAMinuteLater) {
  const TrueDrive drive = crossings(106);
  SimulatedSensors sensors(drive, 1);
  OdometryOptions options;
  options.east_heading_sigma = 10;
  OdometryFilter filter(options);
  drive_by_course(filter, sensors, 0, 89, 34 * kDegree);
  const uint64_t rejected = rejected_courses(filter);
  EXPECT_GT(rejected, 580U);
  drive_by_course(filter, sensors, 89, 105, 34 * kDegree);
  EXPECT_LT(rejected_courses(filter), rejected + 12);
  filter.process_until(seconds(105));
  EXPECT_LT(std::abs(heading_error(drive, filter, 105)), 2 * kDegree);
}

}  // namespace
}  // namespace infuse::motion
