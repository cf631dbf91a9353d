#include <gtest/gtest.h>

#include <random>

#include "tests/fusion/motion/simulated_sensors.hpp"

// A GNSS receiver states how fast, not whether forward or in reverse.
namespace infuse::motion {
namespace {

constexpr double kStep = 0.01, kSweep = 0.1;  // s

OdometryOptions full_options_of_any_heading() {
  OdometryOptions options;
  options.planar = false;
  options.east_heading_sigma = 10;
  return options;
}

TrueDrive drive_at(double speed) {
  return TrueDrive(12, [speed](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[2] = 0.1 * std::sin(0.3 * t);
    twist[3] = speed + 0.5 * std::sin(0.5 * t);
    return twist;
  });
}

bool every(double period, int step) {
  return step % static_cast<int>(std::lround(period / kStep)) == 0;
}

// The noise of the accelerations moves the unknown speed to either side of 0 before the first fix.
TEST(DrivingDirection, IsForwardFromAStartAtSpeed) {
  const TrueDrive drive = drive_at(10);
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SimulatedSensors sensors(drive, seed);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0, 1);
    OdometryFilter filter(full_options_of_any_heading());
    for (int i = 0; i < 1000; ++i) {
      const double t = kStep * i;
      ImuSample imu = sensors.gyro(t, Eigen::Vector3d::Zero());
      imu.linear_acceleration = {0.25 * std::cos(0.5 * t) + noise(random),
                                 drive.twist(t)[2] * drive.twist(t)[3] + noise(random), 9.81};
      filter.add(imu);
      if (i > 5 && every(kSweep, i)) filter.add(sensors.gnss(t));
      if (t <= 1) continue;
      ASSERT_NEAR(filter.report().speed, drive.twist(t)[3], 1.5) << seed << ", " << t;
    }
  }
}

TEST(DrivingDirection, IsThatOfTheLidarWhereGnssCameFirst) {
  for (const double speed : {5.0, -5.0, 12.0, -12.0}) {
    const TrueDrive drive = drive_at(speed);
    SimulatedSensors sensors(drive, 3);
    OdometryFilter filter(full_options_of_any_heading());
    for (int i = 0; i < 1000; ++i) {
      const double t = kStep * i;
      filter.add(sensors.gyro(t, Eigen::Vector3d::Zero()));
      if (every(kSweep, i)) filter.add(sensors.gnss(t));
      if (!every(kSweep, i)) continue;
      const RelativePose pose = i > 0 ? sensors.lidar(t - kSweep, t) : RelativePose{};
      add_sweep(filter, t, i > 0 ? &pose : nullptr);
      if (t <= 1) continue;
      ASSERT_NEAR(filter.report().speed, drive.twist(t)[3], 0.5) << speed << ", " << t;
    }
  }
}

TEST(DrivingDirection, OfAnUnknownMountingIsThatOfTheLidarWhereGnssCameFirst) {
  OdometryOptions options = full_options_of_any_heading();
  options.moves_forward = false;
  const TrueDrive drive = drive_at(10);
  for (const double yaw : {0.0, 1.57, 3.1}) {
    const Eigen::Isometry3d T_vehicle_sensor(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
    SimulatedSensors sensors(drive, 4);
    OdometryFilter filter(options);
    for (int i = 0; i < 1000; ++i) {
      const double t = kStep * i;
      if (every(kSweep, i)) filter.add(sensors.gnss(t));
      if (!every(kSweep, i)) continue;
      RelativePose pose = i > 0 ? sensors.lidar(t - kSweep, t) : RelativePose{};
      pose.T_from_to = T_vehicle_sensor.inverse() * pose.T_from_to * T_vehicle_sensor;
      add_sweep(filter, t, i > 0 ? &pose : nullptr);
      if (t < 1.5) continue;
      const auto motion = filter.trajectory().between(seconds(t - 1), seconds(t - 0.5));
      ASSERT_TRUE(motion.usable()) << motion.reason;
      const Eigen::Vector3d truth =
          T_vehicle_sensor.linear().transpose() *
          (drive.pose(t - 1).inverse() * drive.pose(t - 0.5)).translation();
      ASSERT_LT((motion.T_from_to.translation() - truth).norm(), 0.3) << yaw << ", " << t;
    }
  }
}

}  // namespace
}  // namespace infuse::motion
