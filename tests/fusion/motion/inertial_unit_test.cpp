#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/motion/odometry_filter.hpp"
#include "tests/fusion/motion/true_drive.hpp"

namespace infuse::motion {
namespace {

using geometry::Vector6;

/// Feeds a filter a drive by wheels and an inertial unit at 100 Hz, or accelerations and a yaw
/// rate, as a bus has them. `up` points up in the frame of the truth.
void feed(OdometryFilter& filter, const TrueDrive& drive, const Eigen::Vector3d& bias,
          const Eigen::Vector3d& up, bool gyros = true) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (double t = 0; t < drive.seconds() - 0.1; t += 0.01) {
    WheelOdometry wheels = drive.wheels(t);
    if (gyros) wheels.yaw_rate = std::nan("");
    filter.add(wheels);
    const Vector6 now = drive.twist(t);
    const double acceleration = (drive.twist(t + 0.01)[3] - drive.twist(t - 0.01)[3]) / 0.02;
    const Eigen::Vector3d turning = now.head<3>(), velocity = now.tail<3>();
    const Eigen::Vector3d force = Eigen::Vector3d(acceleration, 0, 0) + turning.cross(velocity) +
                                  drive.pose(t).linear().transpose() * (9.80665 * up);
    ImuSample imu;
    imu.stamp = wheels.stamp;
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<size_t>(i);
      imu.angular_velocity[k] = turning[i] + bias[i] + 0.002 * normal(random);
      imu.linear_acceleration[k] = force[i] + 0.1 * normal(random);
    }
    if (!gyros) imu.angular_velocity.fill(std::nan(""));
    filter.add(imu);
  }
  filter.flush();
}

OdometryOptions spatial() {
  OdometryOptions options;
  options.planar = false;
  return options;
}

/// A three-dimensional path that climbs, banks and turns.
TEST(InertialUnit, FollowsAClimbInThreeDimensions) {
  const TrueDrive drive(30, [](double t) {
    Vector6 twist = Vector6::Zero();
    const double start = std::clamp((t - 3) / 4, 0.0, 1.0);
    twist << 0.02 * std::cos(0.7 * t), -0.03 * std::cos(0.5 * t), 0.2 * std::sin(0.4 * t),
        12 * start, 0, 0;
    twist.head<3>() *= start;
    return twist;
  });
  OdometryFilter filter(spatial());
  geometry::Matrix6 unsure = geometry::Matrix6::Zero();
  unsure(0, 0) = unsure(1, 1) = std::pow(3 * kDegree, 2);
  Eigen::Isometry3d tilted = Eigen::Isometry3d::Identity();  // the orientation is 1.5° wrong
  tilted.linear() = geometry::rotation_exp({1.5 * kDegree, -1.5 * kDegree, 0});
  filter.set_pose(tilted, unsure);
  const Eigen::Vector3d bias(0.002, -0.003, 0.004);
  feed(filter, drive, bias, Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(filter.usable()) << filter.reason();
  const auto pose = filter.trajectory().at(seconds(29.8));
  ASSERT_TRUE(pose.usable());
  const Eigen::Isometry3d truth = drive.pose(29.8);
  ASSERT_GT(std::abs(truth.translation().z()), 3.0) << "the road climbs";
  EXPECT_LT((pose.T_odom_vehicle.translation() - truth.translation()).norm(), 3.0);
  EXPECT_LT(
      geometry::rotation_log(pose.T_odom_vehicle.linear().transpose() * truth.linear()).norm(),
      0.7 * kDegree);
  for (size_t i = 0; i < 3; ++i) {
    const EstimatedParameter estimated = filter.report().gyro_bias[i];
    EXPECT_LT(std::abs(estimated.value - bias[static_cast<int>(i)]), 3 * estimated.sigma);
    EXPECT_LT(estimated.sigma, 1e-3);
  }
}

// The odometry frame is that of the first pose, level or not: gravity must not turn the vehicle
// while it shows how the frame is tilted.
TEST(InertialUnit, AStartOnASlopeTurnsNothing) {
  const TrueDrive drive(20, [](double t) {
    Vector6 twist = Vector6::Zero();
    twist << 0, 0, 0.2 * std::sin(0.4 * t), 8 + 4 * std::sin(0.3 * t), 0, 0;
    return twist;
  });
  OdometryFilter filter(spatial());
  feed(filter, drive, Eigen::Vector3d::Zero(), geometry::rotation_exp({0.03, -0.06, 0}).col(2));
  for (const double t : {1.0, 3.0, 8.0, 19.0}) {
    const auto pose = filter.trajectory().at(seconds(t));
    ASSERT_TRUE(pose.usable());
    const Eigen::Vector3d error =
        geometry::rotation_log(pose.T_odom_vehicle.linear().transpose() * drive.pose(t).linear());
    EXPECT_LT(error.head<2>().norm(), 0.4 * kDegree) << t;
  }
}

// The first accelerations come before anything shows the speed's change: they must not pitch a
// vehicle whose pitch nothing measures.
TEST(InertialUnit, AccelerationsAtTheStartTurnNothing) {
  const TrueDrive drive(5, [](double t) {
    Vector6 twist = Vector6::Zero();
    twist[3] = 10 + 2 * t;
    return twist;
  });
  OdometryFilter filter(spatial());
  feed(filter, drive, Eigen::Vector3d::Zero(), geometry::rotation_exp({0.03, -0.06, 0}).col(2),
       false);
  for (const double t : {0.05, 0.1, 0.2, 0.5, 1.0}) {
    const auto pose = filter.trajectory().at(seconds(t));
    ASSERT_TRUE(pose.usable()) << t;
    EXPECT_LT(geometry::rotation_log(pose.T_odom_vehicle.linear()).norm(), 0.2 * kDegree) << t;
  }
}

}  // namespace
}  // namespace infuse::motion
