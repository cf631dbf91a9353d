#include "fusion/motion/odometry_filter.hpp"
#include "drivers/measurement/angles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/fusion/motion/true_drive.hpp"

namespace infuse::motion {
namespace {

using geometry::Vector6;

/// Stands for `standing` s, then drives on a winding planar road.
Vector6 winding_twist(double t, double standing) {
  Vector6 twist = Vector6::Zero();
  const double start = std::clamp((t - standing) / 6, 0.0, 1.0);
  twist[2] = start * 0.3 * std::sin(0.5 * t);
  twist[3] = start * start * (3 - 2 * start) * (14 + 2 * std::sin(0.3 * t));
  return twist;
}

TrueDrive winding_drive(double length, double standing) {
  return TrueDrive(length, [standing](double t) { return winding_twist(t, standing); });
}

double heading_error(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return geometry::rotation_log(a.linear().transpose() * b.linear()).z();
}

void expect_consistent(const EstimatedParameter& estimated, double truth, double max_sigma,
                       const char* what) {
  EXPECT_LT(std::abs(estimated.value - truth), 3 * estimated.sigma) << what;
  EXPECT_LT(estimated.sigma, max_sigma) << what;
}

TEST(OdometryFilter, FollowsAPlanarDriveWithPerfectSensors) {
  const TrueDrive drive = winding_drive(40, 0);
  OdometryFilter filter;
  for (double t = 0; t < 39.9; t += 0.01) filter.add(drive.wheels(t));
  filter.flush();
  ASSERT_TRUE(filter.usable()) << filter.reason();
  for (const double t : {5.0, 20.003, 39.8}) {
    const auto pose = filter.trajectory().at(seconds(t));
    ASSERT_TRUE(pose.usable()) << pose.reason;
    const Eigen::Isometry3d truth = drive.pose(t);
    EXPECT_LT((pose.T_odom_vehicle.translation() - truth.translation()).norm(), 0.15) << t;
    EXPECT_LT(std::abs(heading_error(pose.T_odom_vehicle, truth)), 0.1 * kDegree) << t;
    EXPECT_EQ(pose.T_odom_vehicle.translation().z(), 0);
  }
  EXPECT_NEAR(filter.report().speed, drive.twist(39.89)[3], 0.02);
  EXPECT_EQ(filter.report().outliers, 0u);
}

// As an inertial navigation system states it, at the centre of the rear axle, in bends too.
TEST(OdometryFilter, ASpeedSourceServesAsWheels) {
  constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
  const TrueDrive drive = winding_drive(40, 0);
  OdometryFilter filter;
  for (double t = 0; t < 39.9; t += 0.05) {
    WheelOdometry sample = drive.wheels(t);
    sample.wheel_speed.fill(kNotMeasured);
    sample.speed = drive.twist(t)[3];
    filter.add(sample);
  }
  filter.flush();
  ASSERT_TRUE(filter.usable()) << filter.reason();
  const auto pose = filter.trajectory().at(seconds(39.8));
  ASSERT_TRUE(pose.usable()) << pose.reason;
  EXPECT_LT((pose.T_odom_vehicle.translation() - drive.pose(39.8).translation()).norm(), 0.5);
  EXPECT_EQ(filter.report().outliers, 0u);
}

TEST(OdometryFilter, LearnsBiasesAtStandstill) {
  const TrueDrive drive = winding_drive(30, 6);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  OdometryFilter filter;
  const double yaw_bias = -0.4 * kDegree, gyro_bias = 0.15 * kDegree;
  for (double t = 0; t < 29.9; t += 0.01) {
    WheelOdometry sample = drive.wheels(t);
    sample.yaw_rate += yaw_bias + 0.004 * normal(random);
    filter.add(sample);
    ImuSample imu;
    imu.stamp = seconds(t + 0.003);
    imu.angular_velocity = {0, 0, drive.twist(t + 0.003)[2] + gyro_bias + 0.003 * normal(random)};
    imu.linear_acceleration.fill(std::nan(""));
    filter.add(imu);
    if (std::abs(t - 5) < 0.001) {
      EXPECT_TRUE(filter.report().standing);
      expect_consistent(filter.report().yaw_rate_bias, yaw_bias, 6e-4, "yaw rate");
    }
  }
  filter.flush();
  EXPECT_FALSE(filter.report().standing);
  expect_consistent(filter.report().yaw_rate_bias, yaw_bias, 6e-4, "yaw rate");
  expect_consistent(filter.report().gyro_bias[2], gyro_bias, 6e-4, "gyro");
  const auto pose = filter.trajectory().at(seconds(29.8));
  ASSERT_TRUE(pose.usable());
  EXPECT_LT(std::abs(heading_error(pose.T_odom_vehicle, drive.pose(29.8))), 0.7 * kDegree);
}

TEST(OdometryFilter, BiasLearnedAtStandstillDoesNotMoveTheVehicle) {
  // Half a minute with an unobservable bias, then a standstill: the heading error is 12° and the
  // position error 25 m when the bias becomes known. The vehicle must not move.
  const TrueDrive drive(36, [](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[3] = t < 30 ? 8.0 : std::max(0.0, 8 - 4 * (t - 30));
    return twist;
  });
  OdometryFilter filter;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const double bias = 0.4 * kDegree;
  for (double t = 0; t < 35.9; t += 0.01) {
    WheelOdometry sample = drive.wheels(t);
    sample.yaw_rate += bias + 0.004 * normal(random);
    filter.add(sample);
  }
  filter.flush();
  expect_consistent(filter.report().yaw_rate_bias, bias, 6e-4, "yaw rate");
  const geometry::Trajectory& trajectory = filter.trajectory();
  double max_distance = 0, max_rotation = 0;
  for (double t = 32.1; t < 35.8; t += 0.02) {
    const auto motion = trajectory.between(seconds(32.05), seconds(t));
    ASSERT_TRUE(motion.usable()) << motion.reason;
    max_distance = std::max(max_distance, motion.T_from_to.translation().norm());
    max_rotation = std::max(max_rotation, geometry::log(motion.T_from_to).head<3>().norm());
  }
  EXPECT_LT(max_distance, 0.1);
  EXPECT_LT(max_rotation, 0.3 * kDegree);
  // The uncorrected error is still in the covariance.
  const auto end = trajectory.at(seconds(35.8));
  const Vector6 error = geometry::log(drive.pose(35.8) * end.T_odom_vehicle.inverse());
  EXPECT_GT(std::abs(error[2]), 8 * kDegree);
  EXPECT_LT(std::abs(error[2]), 3 * std::sqrt(end.covariance(2, 2)));
}

TEST(OdometryFilter, LearnsTheYawRateBiasFromSteeringWithoutStandstill) {
  OdometryOptions options;
  options.steering_ratio = 15;
  options.steering_zero_sigma = 0.005;
  const auto steering_of = [&](const Vector6& twist) {
    const double v = std::max(twist[3], 0.1), ratio = v / options.characteristic_speed;
    return twist[2] * 15 * options.wheelbase * (1 + ratio * ratio) / v;
  };
  const TrueDrive drive(60, [](double t) {
    Vector6 twist = Vector6::Zero();
    twist[2] = 0.02 * std::sin(0.4 * t);
    twist[3] = 16 + 3 * std::sin(0.2 * t);
    return twist;
  });
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  OdometryFilter filter(options);
  const double bias = 0.5 * kDegree;
  for (double t = 0; t < 59.9; t += 0.02) {
    WheelOdometry sample = drive.wheels(t);
    sample.yaw_rate += bias + 0.003 * normal(random);
    sample.steering_angle = steering_of(drive.twist(t)) + 0.003 + 0.002 * normal(random);
    filter.add(sample);
  }
  filter.flush();
  const EstimatedParameter estimated = filter.report().yaw_rate_bias;
  expect_consistent(estimated, bias, 0.003, "yaw rate");
  EXPECT_LT(std::abs(estimated.value - bias), 0.3 * bias) << "most of the bias is learned";
}

TEST(OdometryFilter, LearnsTheWheelScaleOnlyFromGnss) {
  const TrueDrive drive = winding_drive(40, 0);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const bool with_gnss : {false, true}) {
    OdometryFilter filter;
    for (double t = 0; t < 39.9; t += 0.02) {
      WheelOdometry sample = drive.wheels(t);
      for (double& speed : sample.wheel_speed) speed = speed / 1.008 + 0.02 * normal(random);
      filter.add(sample);
      if (with_gnss && std::fmod(t + 1e-9, 0.1) < 0.02) {
        GnssFix fix;
        fix.stamp = seconds(t);
        fix.speed = std::abs(drive.twist(t)[3] + 0.1 * normal(random));
        fix.course = std::nan("");
        fix.valid = true;
        filter.add(fix);
      }
    }
    const EstimatedParameter scale = filter.report().wheel_scale;
    if (with_gnss) {
      expect_consistent(scale, 1.008, 0.003, "scale");
    } else {
      EXPECT_NEAR(scale.value, 1, 1e-3);
      EXPECT_NEAR(scale.sigma, 0.01, 1e-3) << "nothing is learned, and sigma shows it";
    }
  }
}

TEST(OdometryFilter, OutOfOrderSamplesGiveTheSameResult) {
  const TrueDrive drive = winding_drive(5, 0);
  std::vector<WheelOdometry> samples;
  for (double t = 0; t < 4.9; t += 0.005) samples.push_back(drive.wheels(t));
  OdometryFilter in_order, out_of_order;
  for (const WheelOdometry& sample : samples) in_order.add(sample);
  std::vector<WheelOdometry> mixed = samples;
  for (size_t i = 3; i + 3 < mixed.size(); i += 3) std::swap(mixed[i], mixed[i + 2]);
  for (const WheelOdometry& sample : mixed) out_of_order.add(sample);
  in_order.flush();
  out_of_order.flush();
  ASSERT_EQ(in_order.trajectory().size(), out_of_order.trajectory().size());
  for (size_t i = 0; i < in_order.trajectory().size(); ++i) {
    EXPECT_EQ(in_order.trajectory()[i].stamp, out_of_order.trajectory()[i].stamp);
    EXPECT_EQ(in_order.trajectory()[i].T_odom_vehicle.matrix(),
              out_of_order.trajectory()[i].T_odom_vehicle.matrix());
  }
  EXPECT_EQ(out_of_order.report().late, 0u);
  out_of_order.add(drive.wheels(4.0));
  EXPECT_EQ(out_of_order.report().late, 1u);
}

TEST(OdometryFilter, IsUnusableWithoutSamplesAndLeavesAGap) {
  const TrueDrive drive = winding_drive(20, 0);
  OdometryFilter filter;
  EXPECT_STREQ(filter.reason(), "no sample received yet");
  for (double t = 0; t < 19.9; t += 0.01) {
    WheelOdometry sample = drive.wheels(t);
    if (t > 6 && t < 7.5) sample.yaw_rate = std::nan("");  // yaw-rate sensor silent
    if (t > 10 && t < 11.5) sample.wheel_speed.fill(std::nan(""));
    if (t > 14 && t < 15) continue;  // whole bus silent
    filter.add(sample);
    if (std::abs(t - 7.4) < 1e-6) {
      EXPECT_STREQ(filter.reason(), "no source of rotation");
    }
    if (std::abs(t - 11.4) < 1e-6) {
      EXPECT_STREQ(filter.reason(), "no source of speed");
    }
    if (std::abs(t - 5) < 1e-6 || std::abs(t - 9) < 1e-6 || std::abs(t - 18) < 1e-6) {
      EXPECT_STREQ(filter.reason(), "") << t;
    }
  }
  filter.flush();
  EXPECT_TRUE(filter.trajectory().at(seconds(5)).usable());
  EXPECT_TRUE(filter.trajectory().at(seconds(6.3)).usable()) << "a short silence is bridged";
  EXPECT_FALSE(filter.trajectory().at(seconds(7)).usable());
  EXPECT_TRUE(filter.trajectory().at(seconds(9)).usable());
  EXPECT_FALSE(filter.trajectory().at(seconds(11.2)).usable());
  EXPECT_FALSE(filter.trajectory().at(seconds(14.5)).usable());
  const auto before = filter.trajectory().at(seconds(13.9));
  const auto after = filter.trajectory().at(seconds(15.1));
  ASSERT_TRUE(before.usable() && after.usable());
  EXPECT_GT(after.covariance(3, 3), before.covariance(3, 3) + 100) << "20 m/s for a second";
}

TEST(OdometryFilter, RejectsASpinningWheel) {
  const TrueDrive drive = winding_drive(20, 0);
  OdometryFilter filter;
  for (double t = 0; t < 19.9; t += 0.01) {
    WheelOdometry sample = drive.wheels(t);
    if (t > 8 && t < 12) sample.wheel_speed[2] += 6;
    filter.add(sample);
  }
  filter.flush();
  EXPECT_TRUE(filter.usable());
  const auto pose = filter.trajectory().at(seconds(19.8));
  ASSERT_TRUE(pose.usable());
  EXPECT_LT((pose.T_odom_vehicle.translation() - drive.pose(19.8).translation()).norm(), 0.5);
}

TEST(OdometryFilter, ReportsWhenAllWheelsAreRejectedAndRecovers) {
  const TrueDrive drive = winding_drive(20, 0);
  OdometryFilter filter;
  bool was_unusable = false;
  for (double t = 0; t < 19.9; t += 0.01) {
    WheelOdometry sample = drive.wheels(t);
    const bool spinning = t > 8 && t < 10;
    if (spinning) {
      // Jumps that no vehicle can make.
      const double jump = static_cast<int>(t * 100) % 2 == 0 ? 30 : -30;
      for (double& speed : sample.wheel_speed) speed += jump;
    }
    filter.add(sample);
    was_unusable = was_unusable || !filter.usable();
  }
  EXPECT_TRUE(was_unusable);
  EXPECT_GT(filter.report().outliers, 20u);
  EXPECT_TRUE(filter.usable());
  EXPECT_NEAR(filter.report().speed, drive.twist(19.87)[3], 0.1);
}

TEST(OdometryFilter, OneWrongStampIsIgnoredAndAClockSetBackRestarts) {
  const TrueDrive drive = winding_drive(10, 0);
  OdometryFilter filter;
  for (double t = 0; t < 5; t += 0.01) {
    filter.add(drive.wheels(t));
    if (std::abs(t - 3) < 1e-6) {
      WheelOdometry wrong = drive.wheels(t);
      wrong.stamp = Stamp::latest();
      filter.add(wrong);
      wrong.stamp = Stamp::earliest();
      filter.add(wrong);
    }
  }
  EXPECT_EQ(filter.report().invalid_samples, 2u);
  EXPECT_TRUE(filter.usable());
  EXPECT_GT(filter.trajectory().size(), 450u);
  for (double t = 5; t < 9; t += 0.01) {
    WheelOdometry sample = drive.wheels(t);
    sample.stamp = seconds(t - 1000);
    filter.add(sample);
  }
  EXPECT_TRUE(filter.usable());
  EXPECT_TRUE(filter.trajectory().at(seconds(-992)).usable());
  WheelOdometry nothing;
  nothing.wheel_speed.fill(std::nan(""));
  nothing.yaw_rate = nothing.steering_angle = std::nan("");
  const uint64_t invalid_before = filter.report().invalid_samples;
  filter.add(nothing);
  EXPECT_EQ(filter.report().invalid_samples, invalid_before + 1);
}

// Many drives with the noise of the options: the squared error of the final pose, weighted with the
// estimated covariance, must match its degrees of freedom.
TEST(OdometryFilter, CovarianceIsConsistent) {
  constexpr int kDrives = 60;
  const TrueDrive drive = winding_drive(20, 0);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  OdometryOptions options;
  options.yaw_bias_sigma = 0.003;
  double mean_nees = 0;
  for (int n = 0; n < kDrives; ++n) {
    OdometryFilter filter(options);
    const double bias = options.yaw_bias_sigma * normal(random);
    const double scale = 1 + options.wheel_scale_sigma * normal(random);
    for (double t = 0; t < 19.9; t += 0.02) {
      WheelOdometry sample = drive.wheels(t);
      for (double& v : sample.wheel_speed) v = v / scale + options.wheel_noise * normal(random);
      sample.yaw_rate += bias + options.yaw_rate_noise * normal(random);
      filter.add(sample);
    }
    filter.flush();
    const auto pose = filter.trajectory().at(seconds(19.7));
    ASSERT_TRUE(pose.usable());
    const Vector6 error = geometry::log(drive.pose(19.7) * pose.T_odom_vehicle.inverse());
    const Eigen::Vector3d planar(error[2], error[3], error[4]);
    mean_nees += planar.dot(pose.covariance.block<3, 3>(2, 2).inverse() * planar) / (3.0 * kDrives);
  }
  EXPECT_GT(mean_nees, 0.4);
  EXPECT_LT(mean_nees, 1.6);
}

TEST(OdometryFilter, StaysFiniteForArbitraryInput) {
  std::mt19937_64 random(6);
  const double values[] = {
      0,  1,   -1,    1e300, -1e300, std::numeric_limits<double>::infinity(), std::nan(""),
      50, -50, 1e-300};
  const auto any = [&] { return values[random() % 10]; };
  OdometryOptions options;
  options.planar = false;
  options.steering_ratio = 15;
  OdometryFilter filter(options);
  for (int i = 0; i < 3000; ++i) {
    const Stamp stamp = seconds(0.01 * i);
    filter.add(WheelOdometry{stamp, {any(), any(), any(), any()}, any(), any()});
    filter.add(ImuSample{stamp, {any(), any(), any()}, {any(), any(), any()}});
  }
  for (size_t i = 0; i < filter.trajectory().size(); ++i) {
    ASSERT_TRUE(filter.trajectory()[i].T_odom_vehicle.matrix().allFinite());
    ASSERT_TRUE(filter.trajectory()[i].covariance.allFinite());
  }
}

TEST(OdometryFilter, RejectsInvalidOptions) {
  EXPECT_FALSE(OdometryOptions{}.invalid());
  OdometryOptions options;
  options.wheel_noise = 0;
  EXPECT_TRUE(options.invalid());
  options = {};
  options.wheelbase = -1;
  EXPECT_TRUE(options.invalid());
  options = {};
  options.acceleration_walk = std::nan("");
  EXPECT_TRUE(options.invalid());
}

}  // namespace
}  // namespace infuse::motion
