#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "drivers/measurement/angles.hpp"
#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::motion {
namespace {

double position_error(const OdometryFilter& filter, const TrueDrive& drive, double from,
                      double to) {
  const auto motion = filter.trajectory().between(seconds(from), seconds(to));
  EXPECT_TRUE(motion.usable()) << motion.reason;
  const Eigen::Isometry3d truth = drive.pose(from).inverse() * drive.pose(to);
  return (motion.T_from_to.translation() - truth.translation()).norm();
}

TrueDrive flat_drive(double length) {
  return TrueDrive(length, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = 0.15 * std::sin(0.3 * t);
    twist[3] = 12 + 3 * std::sin(0.2 * t);
    return twist;
  });
}

OdometryOptions unknown_heading() {
  OdometryOptions options;
  options.east_heading_sigma = 10;
  return options;
}

uint64_t rejected(const OdometryFilter& filter, OdometrySource source) {
  return filter.report().sources[static_cast<size_t>(source)].rejected;
}

TEST(OdometrySources, GyroAndGnssSuffice) {
  const TrueDrive drive = flat_drive(61);
  SimulatedSensors sensors(drive, 1);
  OdometryFilter filter(unknown_heading());
  for (double t = 0; t < 60; t += 0.01) {
    filter.add(sensors.gyro(t, {0, 0, 0.003}));
    if (std::fmod(t + 1e-9, 0.1) < 0.01) filter.add(sensors.gnss(t));
    ASSERT_TRUE(t < 0.2 || filter.usable()) << filter.reason() << " " << t;
  }
  EXPECT_LT(position_error(filter, drive, 30, 40), 1.5);
  EXPECT_LT(position_error(filter, drive, 40, 40.1), 0.05);
  const EstimatedParameter bias = filter.report().gyro_bias[2];
  EXPECT_NEAR(bias.value, 0.003, 3 * bias.sigma);
  EXPECT_LT(bias.sigma, 1e-3);
  EXPECT_TRUE(filter.report().carries[static_cast<size_t>(OdometrySource::kGnssSpeed)]);
  EXPECT_FALSE(filter.report().carries[static_cast<size_t>(OdometrySource::kWheels)]);
}

// At 1 Hz the trajectory goes on by prediction between the fixes; standing does not end it.
TEST(OdometrySources, GnssAloneSuffices) {
  const TrueDrive drive(60, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = t < 30 ? 0.1 * std::sin(0.3 * t) : 0;
    twist[3] = std::clamp(10 - 2 * (t - 30), 0.0, 10.0);
    return twist;
  });
  for (const double interval : {0.1, 1.0}) {
    SimulatedSensors sensors(drive, 2);
    OdometryFilter filter(unknown_heading());
    for (double t = 0; t < 59; t += interval) {
      filter.add(sensors.gnss(t));
      ASSERT_TRUE(t < 3 || filter.usable()) << filter.reason() << " " << t;
    }
    filter.flush();
    EXPECT_EQ(*filter.trajectory().uncovered_reason(seconds(5), seconds(55)), '\0') << interval;
    EXPECT_LT(position_error(filter, drive, 10, 20), 5) << interval;
    EXPECT_LT(position_error(filter, drive, 45, 55), 1) << interval;
  }
}

// The limit on slow turns, which stands in for the course, once moved the gyro's bias by 0.5°/s.
TEST(OdometrySources, ATurnOnTheSpotLeavesTheGyroBias) {
  const TrueDrive drive(61, [](double t) {
    const bool turns = t > 20 && t < 40;
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = turns ? 10 * kDegree : 0;
    twist[3] = turns ? 0.1 : 10;
    return twist;
  });
  SimulatedSensors sensors(drive, 4);
  OdometryFilter filter(unknown_heading());
  for (double t = 0; t < 60; t += 0.1) {
    filter.add(sensors.wheels(t));
    filter.add(sensors.gyro(t, {0, 0, 0.003}));
    filter.add(sensors.gnss(t));
  }
  const EstimatedParameter bias = filter.report().gyro_bias[2];
  EXPECT_NEAR(bias.value, 0.003, 3 * bias.sigma);
  EXPECT_LT(rejected(filter, OdometrySource::kGnssCourse), 5U);
}

TEST(OdometrySources, SaysWhatIsMissing) {
  const TrueDrive drive = flat_drive(5);
  SimulatedSensors sensors(drive, 3);
  OdometryFilter gyro_only, speed_only;
  for (double t = 0; t < 4; t += 0.02) {
    gyro_only.add(sensors.gyro(t, Eigen::Vector3d::Zero()));
    WheelOdometry speed = sensors.wheels(t);
    speed.yaw_rate = std::nan("");
    speed_only.add(speed);
  }
  EXPECT_STREQ(gyro_only.reason(), "no source of speed");
  EXPECT_STREQ(speed_only.reason(), "no source of rotation");
}

TEST(OdometrySources, LearnsASmallerTyreFromGnssSpeed) {
  const TrueDrive drive = flat_drive(61);
  SimulatedSensors sensors(drive, 4);
  OdometryFilter filter(unknown_heading());
  for (double t = 0; t < 60; t += 0.02) {
    filter.add(sensors.wheels(t, 0.97));
    if (std::fmod(t + 1e-9, 0.1) < 0.02) filter.add(sensors.gnss(t));
  }
  const EstimatedParameter scale = filter.report().wheel_scale;
  EXPECT_NEAR(scale.value, 0.97, 0.005 * 0.97);
  EXPECT_LT(std::abs(scale.value - 0.97), 3 * scale.sigma);
}

// 20 % for 3 s, at once and gradually; named by the counters of its samples.
TEST(OdometrySources, SlippingWheelsAreRejectedWithALidar) {
  const TrueDrive drive = flat_drive(31);
  for (const double rise : {0.0, 1.0}) {
    SimulatedSensors sensors(drive, 5);
    OdometryFilter filter(unknown_heading());
    for (int i = 0; i < 300; ++i) {
      const double t = 0.1 * i;
      for (double s = t - 0.08; s > 0 && s < t + 1e-9; s += 0.02) {
        WheelOdometry wheels = sensors.wheels(s);
        if (s > 15 && s < 18) {
          const double slip = rise > 0 ? std::min(1.0, (s - 15) / rise) : 1.0;
          for (double& v : wheels.wheel_speed) v *= 1 + 0.2 * slip;
        }
        filter.add(wheels);
      }
      const RelativePose pose = sensors.lidar(std::max(0.0, t - 0.1), std::max(t, 1e-3));
      add_sweep(filter, t, i > 0 ? &pose : nullptr);
      ASSERT_TRUE(i < 2 || filter.usable()) << filter.reason() << " " << t;
    }
    EXPECT_LT(position_error(filter, drive, 14.5, 19.5), 0.3) << rise;
    EXPECT_GT(rejected(filter, OdometrySource::kWheels), rise > 0 ? 70u : 140u);
    EXPECT_LT(rejected(filter, OdometrySource::kLidar), 5u);
    EXPECT_TRUE(filter.report().carries[static_cast<size_t>(OdometrySource::kWheels)])
        << "used again after they agree";
  }
}

// At once and gradually, at the rates of receivers. What a receiver does not resolve remains: at 1
// Hz the speed between its fixes. Its delay is unknown to 0.1 s: a slip that grows is seen later.
TEST(OdometrySources, SlippingWheelsAreRejectedWithGnss) {
  constexpr int kDrives = 6;
  const TrueDrive drive = flat_drive(25);
  const std::pair<double, double> intervals_and_bounds[] = {{0.1, 0.25}, {0.2, 0.2}, {1.0, 0.4}};
  for (const auto& [interval, bound] : intervals_and_bounds) {
    for (const double rise : {0.0, 1.0}) {
      double square = 0;
      for (uint64_t seed = 6; seed < 6 + kDrives; ++seed) {
        SimulatedSensors sensors(drive, seed);
        OdometryFilter filter(unknown_heading());
        for (double t = 0; t < 24; t += 0.02) {
          WheelOdometry wheels = sensors.wheels(t);
          if (t > 15 && t < 18) {
            const double slip = rise > 0 ? std::min(1.0, (t - 15) / rise) : 1.0;
            for (double& v : wheels.wheel_speed) v *= 1 + 0.2 * slip;
          }
          filter.add(wheels);
          if (std::fmod(t + 1e-9, interval) < 0.02) filter.add(sensors.gnss(t));
        }
        const double error = position_error(filter, drive, 14.5, 19.5);
        square += error * error / kDrives;
        EXPECT_GT(rejected(filter, OdometrySource::kWheels), 70u);
        EXPECT_LT(rejected(filter, OdometrySource::kGnssSpeed), 5u);
      }
      std::cout << "wheels slip, fixes every " << interval << " s, rise " << rise
                << " s: position error " << std::sqrt(square) << " m\n";
      EXPECT_LT(std::sqrt(square), bound) << interval << " " << rise;
    }
  }
}

// Once each fix turned and stretched the whole path: at 1 Hz the vehicle stepped by 0.34 m (rms).
TEST(OdometrySources, AFixLeavesTheVehicleWhereItIs) {
  const TrueDrive drive = flat_drive(61);
  SimulatedSensors sensors(drive, 8);
  OdometryFilter filter(unknown_heading());
  double square = 0;
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.02 * i;
    filter.add(sensors.wheels(t));
    if (i % 50 == 0) filter.add(sensors.gnss(t));
    const double fix = t - 0.2;  // processed by now
    if (i % 50 != 10 || fix < 10) continue;
    const double error = position_error(filter, drive, fix - 0.1, fix + 0.1);
    square += error * error / 50;
  }
  EXPECT_LT(std::sqrt(square), 0.02);
}

TEST(OdometrySources, GnssThatJumpsOrLiesIsRejected) {
  const TrueDrive drive = flat_drive(71);
  struct Lie {
    double metres, speed, course;
    OdometrySource named;
  };
  const Lie lies[] = {{20, 0, 0, OdometrySource::kGnssPosition},
                      {0, 5, 0, OdometrySource::kGnssSpeed},
                      {0, 0, 0.6, OdometrySource::kGnssCourse}};
  for (const Lie& lie : lies) {
    SimulatedSensors sensors(drive, 7);
    OdometryFilter filter(unknown_heading());
    for (double t = 0; t < 70; t += 0.02) {
      filter.add(sensors.wheels(t));
      if (std::fmod(t + 1e-9, 0.2) >= 0.02) continue;
      GnssFix fix = sensors.gnss(t);
      if (t > 20 && t < 50) {
        fix.latitude += lie.metres / 6.371e6;
        fix.speed += lie.speed;
        fix.course += lie.course;
      }
      filter.add(fix);
    }
    EXPECT_NEAR(static_cast<double>(rejected(filter, lie.named)), 150, 8)
        << static_cast<int>(lie.named);
    EXPECT_LT(filter.report().outliers - rejected(filter, lie.named), 8u);
    EXPECT_LT(position_error(filter, drive, 20, 50), 5);
  }
}

}  // namespace
}  // namespace infuse::motion
