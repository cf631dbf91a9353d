#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "drivers/measurement/angles.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::motion {
namespace {

using geometry::Vector6;

constexpr double kSweep = 0.1;  // s

OdometryOptions full_options() {
  OdometryOptions options;
  options.planar = false;
  return options;
}

/// Squared error of the motion between two times over its covariance, per degree of freedom.
double normalised_error(const OdometryFilter& filter, const TrueDrive& drive, double from,
                        double to) {
  const auto motion = filter.trajectory().between(seconds(from), seconds(to));
  EXPECT_TRUE(motion.usable()) << motion.reason;
  const Eigen::Isometry3d truth = drive.pose(from).inverse() * drive.pose(to);
  const Vector6 error = geometry::log(truth * motion.T_from_to.inverse());
  return error.dot(motion.covariance.ldlt().solve(error)) / 6;
}

double position_error(const OdometryFilter& filter, const TrueDrive& drive, double t) {
  const auto pose = filter.trajectory().at(seconds(t));
  EXPECT_TRUE(pose.usable()) << pose.reason;
  return (pose.T_odom_vehicle.translation() - drive.pose(t).translation()).norm();
}

/// Adds what the wheels measure, at 50 Hz, during the sweep that ends at `t`.
void add_wheels(OdometryFilter& filter, SimulatedSensors& sensors, double t) {
  for (double s = t - kSweep + 0.02; s > 0 && s < t + 1e-9; s += 0.02) {
    filter.add(sensors.wheels(s));
  }
}

TEST(RelativePose, LidarAloneCarriesTheOdometryFromAStartAtSpeed) {
  const TrueDrive drive = town_drive(20);
  SimulatedSensors sensors(drive, 1);
  OdometryFilter filter(full_options());
  add_sweep(filter, 0, nullptr);
  EXPECT_STREQ(filter.reason(), "no source of speed");
  for (double t = kSweep; t < 19.95; t += kSweep) {
    const RelativePose pose = sensors.lidar(t - kSweep, t);
    add_sweep(filter, t, &pose);
    ASSERT_TRUE(filter.usable()) << filter.reason();
    EXPECT_EQ(*filter.trajectory().uncovered_reason(seconds(t - kSweep), seconds(t)), '\0');
    if (t > 2.5 * kSweep) {
      EXPECT_NEAR(filter.report().speed, drive.twist(t)[3], 0.3) << t;
    }
    // Between the ends of the sweeps the corrected trajectory is right too.
    const auto half = filter.trajectory().between(seconds(t - kSweep), seconds(t - kSweep / 2));
    const Eigen::Isometry3d truth = drive.pose(t - kSweep).inverse() * drive.pose(t - kSweep / 2);
    EXPECT_LT((half.T_from_to.translation() - truth.translation()).norm(), 0.05) << t;
  }
  EXPECT_LT(position_error(filter, drive, 19.8), 1.2);
  EXPECT_TRUE(filter.report().carries[static_cast<size_t>(OdometrySource::kLidar)]);
  EXPECT_EQ(filter.report().outliers, 0u);
}

// Sweeps of a lidar at 10 Hz end some microseconds before or after each tenth of a second.
TEST(RelativePose, AMarkHasItsPoseHoweverNearAPredictedOne) {
  const TrueDrive drive = town_drive(20);
  SimulatedSensors sensors(drive, 1);
  OdometryFilter filter(full_options());
  double last = 0;
  add_sweep(filter, last, nullptr);
  for (int i = 1; i < 60; ++i) {
    const double t = i * kSweep + (i % 3 == 0 ? 32e-6 : 0);
    filter.mark(seconds(t), true);
    filter.process_until(seconds(t));
    if (i > 1) {
      EXPECT_TRUE(filter.trajectory().at(seconds(t)).usable()) << i;
      EXPECT_EQ(*filter.trajectory().uncovered_reason(seconds(last), seconds(t)), '\0') << i;
    }
    filter.add(sensors.lidar(last, t));
    last = t;
  }
}

/// A vehicle at 5 m/s that turns by 70° per second from 3 s to 4 s, at once, and dips by 2° at 5 s.
Eigen::Isometry3d abrupt_pose(double t) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  constexpr double kStep = 0.01;  // s
  for (double at = 0; at < t - 1e-9; at += kStep) {
    Vector6 twist = Vector6::Zero();
    twist[2] = at > 3 && at < 4 ? 70 * kDegree : 0;
    twist[1] = at > 5 && at < 5.1 ? 20 * kDegree : 0;
    twist[3] = 5;
    T = T * geometry::exp(kStep * twist);
  }
  return T;
}

// A turn that no constant velocity predicts is no outlier: each rejected motion would be lost.
TEST(RelativePose, LidarAloneIsBelievedInAbruptTurns) {
  OdometryFilter filter(full_options());
  add_sweep(filter, 0, nullptr);
  Vector6 information;
  information << 1e8, 1e8, 1e8, 1e6, 1e6, 1e6;
  for (int i = 1; i < 70; ++i) {
    const double from = (i - 1) * kSweep, to = i * kSweep;
    RelativePose pose;
    pose.from = seconds(from);
    pose.to = seconds(to);
    pose.T_from_to = abrupt_pose(from).inverse() * abrupt_pose(to);
    pose.information = information.asDiagonal();
    add_sweep(filter, to, &pose);
  }
  EXPECT_EQ(filter.report().outliers, 0U);
  const Vector6 error =
      geometry::log(abrupt_pose(6.9).inverse() * abrupt_pose(0.1) *
                    filter.trajectory().between(seconds(0.1), seconds(6.9)).T_from_to);
  EXPECT_LT(error.head<3>().norm(), 0.01);
  EXPECT_LT(error.tail<3>().norm(), 0.2);
  EXPECT_EQ(filter.report().wheel_scale.sigma, 0);  // there are no wheels
}

// What it measures at once as far as no vehicle brakes is an error of the registration.
TEST(RelativePose, AnImpossibleMotionOfTheLidarAloneIsRejected) {
  const TrueDrive drive = town_drive(20);
  SimulatedSensors sensors(drive, 1);
  OdometryFilter filter(full_options());
  add_sweep(filter, 0, nullptr);
  for (int i = 1; i < 60; ++i) {
    RelativePose pose = sensors.lidar((i - 1) * kSweep, i * kSweep);
    if (i == 50) pose.T_from_to.translation().x() -= 0.7;
    add_sweep(filter, i * kSweep, &pose);
    EXPECT_EQ(filter.report().outliers, i < 50 ? 0U : 1U) << i;
  }
}

/// Motion of a sensor at T_vehicle_sensor on the vehicle.
RelativePose seen_from(const Eigen::Isometry3d& T_vehicle_sensor, RelativePose pose) {
  const Eigen::Isometry3d T_sensor_vehicle = T_vehicle_sensor.inverse();
  const geometry::Matrix6 to_vehicle = geometry::adjoint(T_vehicle_sensor);
  pose.T_from_to = T_sensor_vehicle * pose.T_from_to * T_vehicle_sensor;
  pose.information = (to_vehicle.transpose() * pose.information * to_vehicle).eval();
  return pose;
}

// Nobody measured how the lidar is mounted: turned to any side, tilted, off the axle.
TEST(RelativePose, LidarAloneOfUnknownMountingCarriesTheOdometryInAnyDirection) {
  OdometryOptions options = full_options();
  options.moves_forward = false;
  for (const double yaw : {0.0, 0.5, 1.57, 3.1, -1.57}) {
    Eigen::Isometry3d T_vehicle_sensor = Eigen::Isometry3d::Identity();
    T_vehicle_sensor.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()))
                                    .matrix();
    T_vehicle_sensor.translation() << 1.2, 0.3, 1.8;
    const TrueDrive drive = town_drive(16);
    SimulatedSensors sensors(drive, 6);
    OdometryFilter filter(options);
    add_sweep(filter, 0, nullptr);
    const auto truth = [&](double from, double to) -> Eigen::Isometry3d {
      return (drive.pose(from) * T_vehicle_sensor).inverse() * drive.pose(to) * T_vehicle_sensor;
    };
    double short_error = 0;
    for (int i = 1; i < 155; ++i) {
      const double t = kSweep * i;
      const RelativePose pose = seen_from(T_vehicle_sensor, sensors.lidar(t - kSweep, t));
      add_sweep(filter, t, &pose);
      ASSERT_TRUE(filter.usable()) << filter.reason();
      if (i < 3) continue;
      EXPECT_NEAR(filter.report().speed, drive.twist(t)[3], 0.8) << yaw << ", " << t;
      if (i % 10 != 0) continue;
      const auto motion = filter.trajectory().between(seconds(t - 1), seconds(t));
      const Vector6 error = geometry::log(truth(t - 1, t) * motion.T_from_to.inverse());
      short_error += error.dot(motion.covariance.ldlt().solve(error)) / 6 / 15;
    }
    EXPECT_EQ(filter.report().outliers, 0u) << yaw;
    EXPECT_GT(short_error, 0.4) << yaw;
    EXPECT_LT(short_error, 2) << yaw;
    const auto whole = filter.trajectory().between(seconds(0), seconds(15));
    EXPECT_LT((whole.T_from_to.translation() - truth(0, 15).translation()).norm(), 1.2) << yaw;
  }
}

// The course of a GNSS receiver is that of the motion, not of the sensor's x axis.
TEST(RelativePose, UnknownMountingAndGnssAgree) {
  OdometryOptions options = full_options();
  options.moves_forward = false;
  options.east_heading_sigma = 10;
  const TrueDrive drive = town_drive(31);
  SimulatedSensors sensors(drive, 7);
  OdometryFilter filter(options);
  Eigen::Isometry3d T_vehicle_sensor = Eigen::Isometry3d::Identity();
  T_vehicle_sensor.linear() = Eigen::AngleAxisd(1.57, Eigen::Vector3d::UnitZ()).matrix();
  add_sweep(filter, 0, nullptr);
  for (int i = 1; i < 300; ++i) {
    const double t = kSweep * i;
    const RelativePose pose = seen_from(T_vehicle_sensor, sensors.lidar(t - kSweep, t));
    add_sweep(filter, t, &pose);
    if (i % 10 == 0) filter.add(sensors.gnss(t));
  }
  const OdometryReport report = filter.report();
  EXPECT_NEAR(report.speed, drive.twist(29.9)[3], 0.3);
  EXPECT_EQ(report.sources[static_cast<size_t>(OdometrySource::kGnssSpeed)].rejected, 0u);
  EXPECT_EQ(report.sources[static_cast<size_t>(OdometrySource::kGnssCourse)].rejected, 0u);
  EXPECT_EQ(report.sources[static_cast<size_t>(OdometrySource::kLidar)].rejected, 0u);
}

// The trajectory is continuous: correcting a motion leaves the poses before it as they were.
TEST(RelativePose, CorrectsOnlyTheMotionSinceItsBegin) {
  const TrueDrive drive = town_drive(20);
  SimulatedSensors sensors(drive, 2);
  OdometryFilter filter;
  for (double t = 0; t < 10; t += 0.02) filter.add(sensors.wheels(t, 1.02));
  const auto before = filter.trajectory().at(seconds(9.8));
  for (double t = 10; t < 12; t += 0.02) {
    filter.add(sensors.wheels(t, 1.02));
    const double end = std::round(t * 10) / 10;
    if (std::abs(t - end) > 1e-6) continue;
    const RelativePose pose = sensors.lidar(end - kSweep, end);
    add_sweep(filter, end, end > 10.05 ? &pose : nullptr);
  }
  const auto after = filter.trajectory().at(seconds(9.8));
  EXPECT_EQ(before.T_odom_vehicle.matrix(), after.T_odom_vehicle.matrix());
  const auto jump = filter.trajectory().between(seconds(9.99), seconds(10.01));
  EXPECT_NEAR(jump.T_from_to.translation().norm(), 0.02 * drive.twist(10)[3], 0.02);
}

// Many drives with errors as the options state: errors of the motion over 1 s and 10 s must match
// their covariance.
TEST(RelativePose, CovarianceIsHonestOverOneAndTenSeconds) {
  for (const bool with_wheels : {false, true}) {
    double short_error = 0, long_error = 0;
    constexpr int kDrives = 25;
    std::mt19937_64 random(9);
    std::normal_distribution<double> normal;
    for (int n = 0; n < kDrives; ++n) {
      const auto seed = static_cast<uint64_t>(n);
      const TrueDrive drive =
          town_drive(16, 0.37 * n, unseen_motion(16, 300 + seed, full_options()));
      SimulatedSensors sensors(drive, 100 + seed);
      OdometryFilter filter(full_options());
      const double scale = 1 + full_options().wheel_scale_sigma * normal(random);
      const double yaw_bias = full_options().yaw_bias_sigma * normal(random);
      for (int i = 0; i < 155; ++i) {
        const double t = kSweep * i;
        for (double s = t - kSweep + 0.02; with_wheels && s > 0 && s < t + 1e-9; s += 0.02) {
          filter.add(sensors.wheels(s, scale, yaw_bias));
        }
        const RelativePose pose = sensors.lidar(std::max(0.0, t - kSweep), std::max(t, 1e-3));
        add_sweep(filter, t, i > 0 ? &pose : nullptr);
      }
      short_error += normalised_error(filter, drive, 14, 15) / kDrives;
      long_error += normalised_error(filter, drive, 5, 15) / kDrives;
    }
    std::cout << (with_wheels ? "lidar and wheels" : "lidar") << ": normalised error over 1 s "
              << short_error << ", over 10 s " << long_error << "\n";
    EXPECT_GT(short_error, 0.5);
    EXPECT_LT(short_error, 2);
    EXPECT_GT(long_error, 0.5);
    EXPECT_LT(long_error, 2);
  }
}

TEST(RelativePose, LearnsWheelScaleAndGyroBiases) {
  const TrueDrive drive = town_drive(61);
  const Eigen::Vector3d bias(0.002, -0.003, 0.004);
  SimulatedSensors sensors(drive, 3);
  OdometryFilter filter(full_options());
  for (int i = 0; i < 600; ++i) {
    const double t = kSweep * i;
    for (double s = t - kSweep + 0.02; s > 0 && s < t + 1e-9; s += 0.02) {
      WheelOdometry wheels = sensors.wheels(s, 0.97);  // tyres 3 % smaller
      wheels.yaw_rate = std::nan("");
      filter.add(wheels);
      filter.add(sensors.gyro(s, bias));
    }
    const RelativePose pose = sensors.lidar(std::max(0.0, t - kSweep), std::max(t, 1e-3));
    add_sweep(filter, t, i > 0 ? &pose : nullptr);
  }
  const OdometryReport report = filter.report();
  EXPECT_NEAR(report.wheel_scale.value, 0.97, 0.005 * 0.97);
  EXPECT_LT(std::abs(report.wheel_scale.value - 0.97), 3 * report.wheel_scale.sigma);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(report.gyro_bias[i].value, bias[static_cast<int>(i)], 5e-4);
    EXPECT_LT(std::abs(report.gyro_bias[i].value - bias[static_cast<int>(i)]),
              3 * report.gyro_bias[i].sigma);
  }
}

TEST(RelativePose, WheelsCarryWhereTheLidarIsDegenerate) {
  const TrueDrive drive = town_drive(31);
  SimulatedSensors sensors(drive, 4);
  OdometryFilter filter(full_options());
  for (int i = 0; i < 300; ++i) {
    const double t = kSweep * i;
    add_wheels(filter, sensors, t);
    const bool tunnel = t > 10 && t < 25;
    const RelativePose pose = sensors.lidar(std::max(0.0, t - kSweep), std::max(t, 1e-3), tunnel);
    add_sweep(filter, t, i > 0 ? &pose : nullptr);
    ASSERT_TRUE(i < 2 || filter.usable()) << filter.reason();
  }
  const auto motion = filter.trajectory().between(seconds(10), seconds(25));
  const Eigen::Isometry3d truth = drive.pose(10).inverse() * drive.pose(25);
  EXPECT_LT((motion.T_from_to.translation() - truth.translation()).norm(),
            0.01 * 15 * 12);  // 1 % of the way
  EXPECT_EQ(filter.report().outliers, 0u);
}

// As a registration errs at a tunnel's portal: to and fro, by far more than it states.
TEST(RelativePose, WheelsAreRightWhereTheLidarJumps) {
  const TrueDrive drive = town_drive(31);
  SimulatedSensors sensors(drive, 7);
  OdometryFilter filter(full_options());
  for (int i = 0; i < 200; ++i) {
    const double t = kSweep * i;
    add_wheels(filter, sensors, t);
    RelativePose pose = sensors.lidar(std::max(0.0, t - kSweep), std::max(t, 1e-3));
    if (i >= 150 && i < 160) pose.T_from_to.translation().x() += i % 2 == 0 ? 0.3 : -0.2;
    add_sweep(filter, t, i > 0 ? &pose : nullptr);
  }
  const auto motion = filter.trajectory().between(seconds(14.5), seconds(16.5));
  const Eigen::Isometry3d truth = drive.pose(14.5).inverse() * drive.pose(16.5);
  EXPECT_LT((motion.T_from_to.translation() - truth.translation()).norm(), 0.1);
  EXPECT_EQ(filter.report().sources[static_cast<size_t>(OdometrySource::kWheels)].rejected, 0U);
  EXPECT_EQ(filter.report().sources[static_cast<size_t>(OdometrySource::kLidar)].rejected, 10U);
}

// As on a kerb: what wheels do not measure changes too, and the lidar is right in the first sweep.
TEST(RelativePose, TheLidarIsRightWhereTheVehiclePitches) {
  const TrueDrive drive = town_drive(31);
  SimulatedSensors sensors(drive, 9);
  OdometryFilter filter(full_options());
  for (int i = 0; i < 200; ++i) {
    const double t = kSweep * i;
    add_wheels(filter, sensors, t);
    RelativePose pose = sensors.lidar(std::max(0.0, t - kSweep), std::max(t, 1e-3));
    if (i == 150) {
      pose.T_from_to.translation().x() += 0.2;
      pose.T_from_to.rotate(Eigen::AngleAxisd(2 * kDegree, Eigen::Vector3d::UnitY()));
    }
    add_sweep(filter, t, i > 0 ? &pose : nullptr);
    if (i != 150) continue;
    EXPECT_EQ(filter.report().sources[static_cast<size_t>(OdometrySource::kLidar)].rejected, 0U);
    const auto motion = filter.trajectory().between(seconds(t - kSweep), seconds(t));
    EXPECT_LT((motion.T_from_to.translation() - pose.T_from_to.translation()).norm(), 0.05);
    break;
  }
}

// The lidar cannot tell speed from turn here, and claims a turn of 0.3° that was none.
TEST(RelativePose, AWrongTurnOfTheLidarLeavesTheSpeedOfTheWheels) {
  const TrueDrive drive = town_drive(31);
  SimulatedSensors sensors(drive, 8);
  OdometryFilter filter(full_options());
  Vector6 free = Vector6::Zero();
  free[2] = 0.03, free[3] = 1;  // rad, m
  const geometry::Matrix6 known =
      geometry::Matrix6::Identity() - free * free.transpose() / free.squaredNorm();
  for (int i = 0; i < 200; ++i) {
    const double t = kSweep * i;
    add_wheels(filter, sensors, t);
    RelativePose pose = sensors.lidar(std::max(0.0, t - kSweep), std::max(t, 1e-3));
    if (t > 10) pose.information = known * pose.information * known;
    if (i == 150) pose.T_from_to.rotate(Eigen::AngleAxisd(0.3 * kDegree, Eigen::Vector3d::UnitZ()));
    add_sweep(filter, t, i > 0 ? &pose : nullptr);
    if (i < 20) continue;
    ASSERT_NEAR(filter.report().speed, drive.twist(t)[3], 0.3) << t;
  }
}

TEST(RelativePose, OfUnknownTimesIsIgnored) {
  OdometryFilter filter(full_options());
  const TrueDrive drive = town_drive(2);
  SimulatedSensors sensors(drive, 5);
  add_sweep(filter, 0.5, nullptr);
  RelativePose pose = sensors.lidar(0.2, 0.5);
  filter.add(pose);
  EXPECT_EQ(filter.report().late, 1u);
  pose = sensors.lidar(0.5, 0.6);
  pose.T_from_to.translation().x() = std::nan("");
  add_sweep(filter, 0.6, &pose);
  EXPECT_EQ(filter.report().late, 2u);
  pose = sensors.lidar(0.6, 0.7);
  pose.information.setZero();
  add_sweep(filter, 0.7, &pose);
  EXPECT_FALSE(filter.usable());
}

TEST(RelativePose, AllocatesNothing) {
  if (!kAllocationsCounted) GTEST_SKIP() << "the sanitizer has its own allocator";
  const TrueDrive drive = town_drive(3);
  SimulatedSensors sensors(drive, 6);
  OdometryFilter filter;
  add_sweep(filter, 0, nullptr);
  const size_t before = allocation_count();
  for (double t = kSweep; t < 2; t += kSweep) {
    const RelativePose pose = sensors.lidar(t - kSweep, t);
    add_sweep(filter, t, &pose);
  }
  EXPECT_EQ(allocation_count(), before);
}

// A lidar that sees no more than a tunnel's walls measures the rotation, not the speed.
TEST(RelativePose, SaysThatALidarInATunnelShowsNoSpeed) {
  const TrueDrive drive = town_drive(20);
  SimulatedSensors sensors(drive, 1);
  OdometryFilter filter(full_options());
  add_sweep(filter, 0, nullptr);
  for (double t = kSweep; t < 8; t += kSweep) {
    const bool tunnel = t > 3 && t < 6;
    const RelativePose pose = sensors.lidar(t - kSweep, t, tunnel);
    add_sweep(filter, t, &pose);
    if (t > 3.7 && tunnel) {
      EXPECT_STREQ(filter.reason(),
                   "no source of speed: the lidar's surroundings do not determine it")
          << t;
      EXPECT_FALSE(filter.trajectory().at(seconds(t)).usable()) << t;
    } else if (t < 3 || t > 6.3) {
      EXPECT_TRUE(filter.usable()) << t << ": " << filter.reason();
      EXPECT_TRUE(filter.trajectory().at(seconds(t)).usable()) << t;
    }
  }
  EXPECT_FALSE(filter.trajectory().between(seconds(2.8), seconds(7)).usable());
}

}  // namespace
}  // namespace infuse::motion
