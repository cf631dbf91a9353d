#include "fusion/geometry/trajectory.hpp"

#include <gtest/gtest.h>

#include <random>

namespace infuse::geometry {
namespace {

constexpr int64_t kNsPerMs = 1'000'000;

Stamp at_ms(int64_t ms) { return Stamp::from_ns(ms * kNsPerMs); }

/// Pose after t seconds at 10 m/s on a circle to the left, 0.5 rad/s, from the origin along x, in
/// closed form.
Eigen::Isometry3d on_circle(double t) {
  const double radius = 20, angle = 0.5 * t;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() << radius * std::sin(angle), radius * (1 - std::cos(angle)), 0;
  return T;
}

Trajectory make_circle(const TrajectoryOptions& options = {}, int poses = 20) {
  Trajectory trajectory(options);
  for (int i = 0; i < poses; ++i) {
    StampedPose pose{at_ms(100 * i), on_circle(0.1 * i), Matrix6::Identity() * 1e-4 * i};
    EXPECT_TRUE(trajectory.append(pose));
  }
  return trajectory;
}

TEST(Trajectory, InterpolatesACircleExactly) {
  const Trajectory trajectory = make_circle();
  for (const int64_t ms : {0, 30, 50, 100, 730, 1899, 1900}) {
    const PoseAt pose = trajectory.at(at_ms(ms));
    ASSERT_TRUE(pose.usable()) << pose.reason;
    const Eigen::Isometry3d expected = on_circle(static_cast<double>(ms) * 1e-3);
    EXPECT_LT((pose.T_odom_vehicle.matrix() - expected.matrix()).norm(), 1e-10) << ms;
    EXPECT_NEAR(pose.covariance(2, 2), 1e-6 * static_cast<double>(ms), 1e-12);
  }
}

TEST(Trajectory, ReportsTimesThatItDoesNotCover) {
  Trajectory trajectory = make_circle();
  EXPECT_FALSE(Trajectory().at(at_ms(0)).usable());
  EXPECT_STREQ(trajectory.at(at_ms(-1)).reason, "the time is before the first pose");
  EXPECT_STREQ(trajectory.at(at_ms(1901)).reason, "the time is after the last pose");
  ASSERT_TRUE(trajectory.append({at_ms(2500), on_circle(2.5), Matrix6::Zero()}));
  EXPECT_STREQ(trajectory.at(at_ms(2000)).reason, "the poses around the time are too far apart");
  EXPECT_TRUE(trajectory.at(at_ms(2500)).usable());
  EXPECT_FALSE(trajectory.between(at_ms(1800), at_ms(2500)).usable()) << "spans the gap";
  EXPECT_STREQ(trajectory.uncovered_reason(at_ms(0), at_ms(1900)), "");
  EXPECT_STRNE(trajectory.uncovered_reason(at_ms(0), at_ms(2500)), "");
  EXPECT_STRNE(trajectory.uncovered_reason(at_ms(-5), at_ms(5)), "");
  EXPECT_FALSE(trajectory.append({at_ms(2500), on_circle(0), Matrix6::Zero()})) << "not later";
}

TEST(Trajectory, ExtrapolatesUpToTheLimitWithGrowingCovariance) {
  TrajectoryOptions options;
  options.max_extrapolation = Duration(100 * kNsPerMs);
  const Trajectory trajectory = make_circle(options);
  const PoseAt pose = trajectory.at(at_ms(2000));
  ASSERT_TRUE(pose.usable());
  EXPECT_LT((pose.T_odom_vehicle.matrix() - on_circle(2.0).matrix()).norm(), 1e-10);
  const PoseAt last = trajectory.at(at_ms(1900));
  EXPECT_GT(pose.covariance.trace(), last.covariance.trace() + 3 * 0.01 * 0.099);
  EXPECT_FALSE(trajectory.at(at_ms(2001)).usable());
}

TEST(Trajectory, MotionBetweenTwoTimesInBothDirections) {
  const Trajectory trajectory = make_circle();
  const MotionBetween there = trajectory.between(at_ms(250), at_ms(1210));
  const MotionBetween back = trajectory.between(at_ms(1210), at_ms(250));
  ASSERT_TRUE(there.usable() && back.usable());
  // On a circle the motion depends only on the difference of the times.
  EXPECT_LT((there.T_from_to.matrix() - on_circle(0.96).matrix()).norm(), 1e-9);
  EXPECT_LT((there.T_from_to * back.T_from_to).translation().norm(), 1e-9);
  EXPECT_GT(there.covariance.diagonal().minCoeff(), 0);
  EXPECT_GT(back.covariance.diagonal().minCoeff(), 0);
}

// Steps with independent noise whose covariance accumulates as in dead reckoning: the covariance of
// the motion between two times equals its spread over many drives.
TEST(Trajectory, CovarianceOfAMotionEqualsItsSpread) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Vector6 sigma;
  sigma << 1e-3, 1e-3, 3e-3, 0.01, 0.02, 0.005;
  Vector6 step_twist;
  step_twist << 0, 0, 0.05, 1, 0, 0;
  constexpr int kDrives = 1000;
  Matrix6 spread = Matrix6::Zero(), stated = Matrix6::Zero();
  const Eigen::Isometry3d step = exp(step_twist);
  Eigen::Isometry3d true_motion = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 12; ++i) true_motion = true_motion * step;
  for (int drive = 0; drive < kDrives; ++drive) {
    Trajectory trajectory({.capacity = 32});
    StampedPose pose;
    for (int i = 0; i <= 20; ++i) {
      pose.stamp = at_ms(100 * i);
      trajectory.append(pose);
      Vector6 noise;
      for (int k = 0; k < 6; ++k) noise[k] = sigma[k] * normal(random);
      pose.T_odom_vehicle = pose.T_odom_vehicle * exp(noise) * step;
      pose.covariance += transform_covariance(trajectory[static_cast<size_t>(i)].T_odom_vehicle,
                                              sigma.cwiseAbs2().asDiagonal());
    }
    const MotionBetween motion = trajectory.between(at_ms(500), at_ms(1700));
    const Vector6 error = log(motion.T_from_to * true_motion.inverse());
    spread += error * error.transpose() / kDrives;
    stated += motion.covariance / kDrives;
  }
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(spread(k, k) / stated(k, k), 1, 0.2) << k;
}

TEST(Trajectory, KeepsTheNewestPosesWhenFull) {
  TrajectoryOptions options;
  options.capacity = 8;
  const Trajectory trajectory = make_circle(options);
  EXPECT_EQ(trajectory.size(), 8u);
  EXPECT_EQ(trajectory[0].stamp, at_ms(1200));
  EXPECT_FALSE(trajectory.at(at_ms(1100)).usable());
  EXPECT_TRUE(trajectory.at(at_ms(1850)).usable());
}

TEST(Trajectory, RejectsInvalidOptions) {
  EXPECT_FALSE(TrajectoryOptions{}.invalid());
  EXPECT_TRUE(TrajectoryOptions{.capacity = 1}.invalid());
  EXPECT_TRUE(TrajectoryOptions{.max_gap = Duration(0)}.invalid());
  EXPECT_TRUE(TrajectoryOptions{.rotation_growth = -1}.invalid());
}

}  // namespace
}  // namespace infuse::geometry
