#include "fusion/registration/lidar_odometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/fusion/registration/random_room.hpp"

namespace infuse::registration {
namespace {

constexpr size_t kPoints = 20'000;

Eigen::Isometry3d mounting() {
  geometry::Vector6 twist;
  twist << 0.01, 0.02, 0.3, 0.8, 0.1, 1.7;
  return geometry::exp(twist);
}

/// Twist of a bend at 8 m/s, and the pose of the vehicle in the room on it.
geometry::Vector6 twist_per_second() {
  geometry::Vector6 twist;
  twist << 0, 0, 0.3, 8, 0, 0;
  return twist;
}
Eigen::Isometry3d T_room_vehicle(double seconds) {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  start.translation() << -10, -4, -2;
  return start * geometry::exp(seconds * twist_per_second());
}

Stamp stamp(double seconds) { return Stamp::from_ns(1'000'000'000) + from_seconds(seconds); }

geometry::MotionBetween measured_motion(const Eigen::Isometry3d& T_from_to) {
  geometry::MotionBetween motion;
  motion.T_from_to = T_from_to;
  motion.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4;
  return motion;
}

TEST(LidarOdometry, FollowsAVehicleThatIsMovingWhenItStarts) {
  LidarOdometry odometry(mounting());
  for (int k = 0; k < 15; ++k) {
    const double seconds = 0.1 * k;
    const PointCloud sweep = random_room(static_cast<unsigned>(k + 1), kPoints, 0.02,
                                         T_room_vehicle(seconds) * mounting());
    const LidarOdometryResult result = odometry.align(sweep.points(), stamp(seconds));
    odometry.add(sweep.points(), result);
    if (k == 0) {
      EXPECT_STREQ(result.reason, "the first sweep starts the map");
      continue;
    }
    ASSERT_TRUE(result.usable()) << k << ": " << result.reason;
    EXPECT_EQ(result.registration.free_directions, 0);
    EXPECT_EQ(result.motion.from, stamp(seconds - 0.1));
    const geometry::Vector6 error =
        geometry::log(geometry::exp(0.1 * twist_per_second()) * result.motion.T_from_to.inverse());
    EXPECT_LT(error.head<3>().norm(), 3e-3) << k;
    EXPECT_LT(error.tail<3>().norm(), 0.03) << k;
    const Eigen::Isometry3d T_map_vehicle = T_room_vehicle(0).inverse() * T_room_vehicle(seconds);
    EXPECT_LT((T_map_vehicle.inverse() * result.T_map_vehicle).translation().norm(), 0.05) << k;
    // The stated accuracy is of the size of the error.
    EXPECT_LT(error.dot(result.motion.information * error), 60) << k;
    EXPECT_GT(error.dot(result.motion.information * error), 0.01) << k;
  }
}

TEST(LidarOdometry, KeepsTheGuessAndSaysWhyWhereItSeesNothing) {
  LidarOdometry odometry(mounting());
  const PointCloud sweep = random_room(1, kPoints, 0.02, T_room_vehicle(0) * mounting());
  odometry.add(sweep.points(), odometry.align(sweep.points(), stamp(0)));
  const Eigen::Isometry3d guess = geometry::exp(0.1 * twist_per_second());
  LidarOdometryResult result = odometry.align(PointCloud().points(), stamp(0.1), guess);
  EXPECT_STREQ(result.reason, "the sweep has too few points");
  EXPECT_TRUE(result.motion.information.isZero());
  odometry.add(PointCloud().points(), result);
  EXPECT_STREQ(odometry.align(sweep.points(), stamp(0.1), guess).reason,
               "the sweep is not later than the one before");
  PointCloud far = sweep;
  for (float& x : far.x) x += 60;
  result = odometry.align(far.points(), stamp(0.2), guess);
  EXPECT_STREQ(result.reason, "too few points lie on planes of the map");
  EXPECT_TRUE(result.motion.information.isZero());
  PointCloud missing = sweep;
  std::fill(missing.x.begin(), missing.x.end(), std::numeric_limits<float>::quiet_NaN());
  result = odometry.align(missing.points(), stamp(0.2), guess);
  EXPECT_STREQ(result.reason, "the sweep has too few points");
  PointCloud ten = sweep;
  ten.resize(10);
  result = odometry.align(ten.points(), stamp(0.2), guess);
  EXPECT_STREQ(result.reason, "the sweep has too few points");
}

// A sweep that repeats the one before is that of a vehicle that stands.
TEST(LidarOdometry, StandsWhereTheSweepsAreIdentical) {
  LidarOdometry odometry(mounting());
  const PointCloud sweep = random_room(1, kPoints, 0.02, T_room_vehicle(0) * mounting());
  odometry.add(sweep.points(), odometry.align(sweep.points(), stamp(0)));
  const LidarOdometryResult result = odometry.align(sweep.points(), stamp(0.1));
  ASSERT_TRUE(result.usable()) << result.reason;
  EXPECT_LT(geometry::log(result.motion.T_from_to).norm(), 0.005);
  EXPECT_TRUE(result.motion.information.allFinite());
}

TEST(LidarOdometry, DoesNotAllocateAfterWarmUp) {
  LidarOdometry odometry(mounting());
  const PointCloud sweep = random_room(1, kPoints, 0.02, T_room_vehicle(0) * mounting());
  size_t before = 0;
  for (int k = 0; k < 6; ++k) {
    before = allocation_count();
    const geometry::MotionBetween prior = measured_motion(Eigen::Isometry3d::Identity());
    odometry.add(sweep.points(), odometry.align(sweep.points(), stamp(0.1 * k),
                                                Eigen::Isometry3d::Identity(), &prior));
  }
  EXPECT_EQ(allocation_count(), before);
}

/// A sweep measured while the vehicle moves.
Sweep moving_sweep(unsigned seed, double seconds) {
  constexpr int kSlices = 50;
  Sweep sweep;
  sweep.resize(kPoints);
  sweep.stamp = stamp(seconds);
  sweep.span = from_seconds(0.1);
  for (int slice = 0; slice < kSlices; ++slice) {
    const double offset = 0.1 * slice / kSlices;
    const PointCloud part =
        random_room(1000 * seed + static_cast<unsigned>(slice), kPoints / kSlices, 0.02,
                    T_room_vehicle(seconds + offset) * mounting());
    for (size_t i = 0; i < part.size(); ++i) {
      const size_t at = static_cast<size_t>(slice) * (kPoints / kSlices) + i;
      sweep.x[at] = part.x[i];
      sweep.y[at] = part.y[i];
      sweep.z[at] = part.z[i];
      sweep.time_offset_ns[at] = static_cast<int32_t>(from_seconds(offset).count());
    }
  }
  return sweep;
}

TEST(LidarTrajectory, DeskewsByItsOwnMotionFromTheFirstSweepOn) {
  LidarTrajectory trajectory(mounting());
  Eigen::Isometry3d last;
  for (int k = 0; k < 8; ++k) {
    const LidarOdometryResult& result =
        trajectory.add(moving_sweep(static_cast<unsigned>(k + 1), 0.1 * k));
    if (k == 0) continue;
    ASSERT_TRUE(result.usable()) << k << ": " << result.reason;
    const geometry::Vector6 error =
        geometry::log(geometry::exp(0.1 * twist_per_second()) * result.motion.T_from_to.inverse());
    EXPECT_LT(error.tail<3>().norm(), 0.04) << k;
    last = result.T_map_vehicle;
  }
  const Eigen::Isometry3d truth = T_room_vehicle(0.05).inverse() * T_room_vehicle(0.75);
  EXPECT_LT((truth.inverse() * last).translation().norm(), 0.06);
  EXPECT_TRUE(trajectory.deskewed().usable());
}

/// The room as a hall of 90 by 60 m.
PointCloud hall(unsigned seed, const Eigen::Isometry3d& T_hall_sensor) {
  constexpr float kScale = 3;
  Eigen::Isometry3d T_room_sensor = T_hall_sensor;
  T_room_sensor.translation() /= kScale;
  PointCloud cloud = random_room(seed, 100'000, 0.01, T_room_sensor);
  for (FieldVector<float>* field : {&cloud.x, &cloud.y, &cloud.z}) {
    for (float& value : *field) value *= kScale;
  }
  return cloud;
}

// Where walls are far, a small error of the heading moves their points past the robust width: it
// must not narrow before the steps do. One sweep without a pose costs the next ones their guess.
TEST(LidarOdometry, FindsAHeadingThatIsWrongByMoreThanTheRobustWidth) {
  LidarOdometry odometry(mounting());
  const PointCloud first = hall(1, T_room_vehicle(0) * mounting());
  odometry.add(first.points(), odometry.align(first.points(), stamp(0)));
  const PointCloud second = hall(2, T_room_vehicle(0.1) * mounting());
  const Eigen::Isometry3d truth = geometry::exp(0.1 * twist_per_second());
  for (const double degrees : {-4.0, 4.0}) {  // as a turn adds within two sweeps
    const Eigen::Isometry3d guess =
        truth * Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitZ());
    const LidarOdometryResult result = odometry.align(second.points(), stamp(0.1), guess);
    ASSERT_TRUE(result.usable()) << degrees << ": " << result.reason;
    const geometry::Vector6 error = geometry::log(truth * result.motion.T_from_to.inverse());
    EXPECT_LT(error.head<3>().norm(), 2e-3) << degrees;
    EXPECT_LT(error.tail<3>().norm(), 0.03) << degrees;
  }
}

// After a jerk that is too fast to follow, wrong maxima lie nearer than the right one: none may be
// claimed, nor the motion from a pose that was a guess, and sweeps added there would blur the map.
TEST(LidarOdometry, ClaimsNoWrongMotionAfterAJerk) {
  constexpr int kJerk = 12, kLast = 24;
  const int max_failures = LidarOdometryOptions{}.max_failures;
  int lost = 0, found_again = 0;
  for (int degrees = 10; degrees <= 80; degrees += 5) {
    const Eigen::AngleAxisd jerk(degrees * kDegree, Eigen::Vector3d(0, 0.3, 1).normalized());
    LidarOdometry odometry(mounting());
    Eigen::Isometry3d last, located;  // truth, at the sweep before and the last with a pose
    int failures = 0;
    for (int k = 0; k <= kLast; ++k) {
      Eigen::Isometry3d T_room = T_room_vehicle(0.1 * k);
      if (k >= kJerk) T_room.rotate(jerk);
      const PointCloud sweep =
          random_room(static_cast<unsigned>(k + 1), kPoints, 0.02, T_room * mounting());
      const LidarOdometryResult result = odometry.align(sweep.points(), stamp(0.1 * k));
      odometry.add(sweep.points(), result);
      const bool claims = !result.motion.information.isZero();
      EXPECT_TRUE(claims || k == 0 || (k >= kJerk && k < kLast)) << degrees << ", sweep " << k;
      if (claims) {
        const geometry::Vector6 error =
            geometry::log(last.inverse() * T_room * result.motion.T_from_to.inverse());
        EXPECT_LT(error.head<3>().norm(), 0.01) << degrees << " degrees, sweep " << k;
        EXPECT_LT(error.tail<3>().norm(), 0.1) << degrees << " degrees, sweep " << k;
      }
      if (k > 0 && result.usable() && failures > 0 && failures < max_failures) {
        ++found_again;
        EXPECT_FALSE(claims) << degrees << " degrees, sweep " << k;
        const geometry::Vector6 velocity =
            geometry::log(located.inverse() * T_room) / (0.1 * (failures + 1));
        EXPECT_LT((result.velocity - velocity).norm(), 0.1) << degrees << " degrees, sweep " << k;
      }
      failures = k == 0 || result.usable() ? 0 : failures + 1;
      lost += failures > 0 ? 1 : 0;
      if (failures == 0) located = T_room;
      last = T_room;
    }
  }
  EXPECT_GT(lost, 5);
  EXPECT_GT(found_again, 0);
}

// A clock that is set back and on again: no velocity from times that do not rise.
TEST(LidarOdometry, IgnoresTimesBeforeTheLastPose) {
  LidarOdometry odometry(mounting());
  for (const double seconds : {0.0, 0.1, 0.2, 0.05, 0.15, 0.3}) {
    const PointCloud sweep = random_room(static_cast<unsigned>(100 * seconds) + 1, kPoints, 0.02,
                                         T_room_vehicle(seconds) * mounting());
    const LidarOdometryResult result = odometry.align(sweep.points(), stamp(seconds));
    odometry.add(sweep.points(), result);
    EXPECT_EQ(result.usable(), seconds == 0.1 || seconds == 0.2 || seconds == 0.3) << seconds;
    if (!result.usable()) continue;
    EXPECT_NEAR(result.velocity(3), 8, 0.5) << seconds;
  }
}

/// Rings on a level field with short grass: heights of centimetres, noise of 2 cm.
PointCloud open_field(unsigned seed, const Eigen::Isometry3d& T_field_lidar) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.02);
  std::uniform_real_distribution<double> unit(0, 1);
  PointCloud cloud;
  for (double elevation = 1.5; elevation < 25; elevation += 0.5) {
    for (double azimuth = 0; azimuth < 360; azimuth += 0.4) {
      const double e = -elevation * kDegree, a = azimuth * kDegree;
      const Eigen::Vector3d ray(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      const Eigen::Vector3d in_field = T_field_lidar.linear() * ray;
      const double grass = 0.05 * unit(random) * unit(random);
      const double range = (grass - T_field_lidar.translation().z()) / in_field.z() + noise(random);
      if (!(range > 2 && range < 80)) continue;
      const Eigen::Vector3f p = (range * ray).cast<float>();
      cloud.x.push_back(p.x()), cloud.y.push_back(p.y()), cloud.z.push_back(p.z());
    }
  }
  return cloud;
}

// The rings stay where they are seen from the vehicle, and noise tilts the ground's normals:
// neither says that the vehicle stands.
// Each sweep has a shell of noise around the lidar: there is always some plane near a point of it.
TEST(LidarTrajectory, FindsNoMotionInRangesThatAreNoise) {
  std::mt19937 random(1);
  std::normal_distribution<double> range(10, 1);
  LidarTrajectory trajectory(Eigen::Isometry3d::Identity());
  for (int k = 0; k < 4; ++k) {
    Sweep sweep;
    constexpr size_t kRings = 32, kColumns = 900;
    sweep.resize(kRings * kColumns);
    sweep.stamp = Stamp::from_ns(100'000'000 * k);
    sweep.span = Duration(100'000'000);
    for (size_t i = 0; i < sweep.size(); ++i) {
      const double azimuth = -2 * std::numbers::pi * static_cast<double>(i / kRings) / kColumns;
      const double elevation = (static_cast<double>(i % kRings) - 23) * 1.33 * kDegree;
      const double r = range(random);
      sweep.x[i] = static_cast<float>(r * std::cos(elevation) * std::cos(azimuth));
      sweep.y[i] = static_cast<float>(r * std::cos(elevation) * std::sin(azimuth));
      sweep.z[i] = static_cast<float>(r * std::sin(elevation));
      sweep.range[i] = static_cast<float>(r);
      sweep.ring[i] = static_cast<uint16_t>(i % kRings);
      sweep.column[i] = static_cast<uint16_t>(i / kRings);
      sweep.time_offset_ns[i] = static_cast<int32_t>(i / kRings) * 111'111;
    }
    EXPECT_FALSE(trajectory.add(sweep).usable()) << k;
  }
}

TEST(LidarOdometry, ClaimsNoSpeedOnAnOpenField) {
  Eigen::Isometry3d T_vehicle_lidar = Eigen::Isometry3d::Identity();
  T_vehicle_lidar.translation().z() = 1.8;
  LidarOdometry odometry(T_vehicle_lidar);
  int usable = 0;
  for (unsigned k = 0; k < 25; ++k) {
    Eigen::Isometry3d T_field_vehicle = Eigen::Isometry3d::Identity();
    T_field_vehicle.translation().x() = 1.4 * k;
    const PointCloud sweep = open_field(k + 1, T_field_vehicle * T_vehicle_lidar);
    std::optional<Eigen::Isometry3d> guess;
    if (k > 0) guess = Eigen::Isometry3d(Eigen::Translation3d(1.4, 0, 0));
    const LidarOdometryResult result = odometry.align(sweep.points(), stamp(0.1 * k), guess);
    odometry.add(sweep.points(), result);
    if (k == 0 || !result.usable()) continue;
    ++usable;
    EXPECT_EQ(result.registration.free_directions, 3) << k;
    EXPECT_NEAR(result.motion.T_from_to.translation().x(), 1.4, 0.02) << k;
    EXPECT_LT(result.motion.information(3, 3), 20) << k;
    EXPECT_GT(result.motion.information(5, 5), 5) << k;  // height
  }
  EXPECT_GE(usable, 20);
}

// Wheels know how far the vehicle drove, and a field does not show it: the prior stays, whatever
// the guess that the search begins with, and is not counted as the lidar's.
TEST(LidarOdometry, APriorStaysWhereTheGeometryShowsNothing) {
  Eigen::Isometry3d T_vehicle_lidar = Eigen::Isometry3d::Identity();
  T_vehicle_lidar.translation().z() = 1.8;
  LidarOdometry odometry(T_vehicle_lidar);
  const Eigen::Isometry3d step(Eigen::Translation3d(1.4, 0, 0));
  const Eigen::Isometry3d wrong(Eigen::Translation3d(1.1, 0.1, 0.05) *
                                Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ()));
  for (unsigned k = 0; k < 12; ++k) {
    Eigen::Isometry3d T_field_vehicle = Eigen::Isometry3d::Identity();
    T_field_vehicle.translation().x() = 1.4 * k;
    const PointCloud sweep = open_field(k + 1, T_field_vehicle * T_vehicle_lidar);
    const geometry::MotionBetween prior = measured_motion(step);
    const LidarOdometryResult result =
        odometry.align(sweep.points(), stamp(0.1 * k), k > 0 ? wrong : step, &prior);
    odometry.add(sweep.points(), result);
    if (k == 0) continue;
    ASSERT_TRUE(result.usable()) << k << ": " << result.reason;
    const geometry::Vector6 error = geometry::log(step.inverse() * result.motion.T_from_to);
    EXPECT_LT(error.head<3>().norm(), 2e-3) << k;
    EXPECT_LT(error.tail<3>().norm(), 0.02) << k;
    EXPECT_LT(result.motion.information(3, 3), 20) << k;
  }
}

// The prior's covariance is in the vehicle's axes, whatever its heading in the map: where few
// points resist, a prior that is wrong ahead and to the left moves the pose in the direction that
// it claims.
TEST(LidarOdometry, APriorIsWeighedInTheAxesOfTheVehicle) {
  LidarOdometryOptions options;
  options.match_voxel_size = 8;
  options.min_match_points = 60;
  options.min_inliers = 30;
  LidarOdometry odometry(mounting(), options);
  Eigen::Isometry3d T_room_vehicle_now = T_room_vehicle(0);
  for (unsigned k = 0; k < 3; ++k) {
    const Eigen::Isometry3d step =
        k == 1
            ? Eigen::Isometry3d(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()))
            : Eigen::Isometry3d::Identity();
    T_room_vehicle_now = T_room_vehicle_now * step;
    const PointCloud sweep = random_room(k + 1, kPoints, 0.02, T_room_vehicle_now * mounting());
    geometry::MotionBetween prior = measured_motion(step);
    if (k == 2) {
      prior.T_from_to.translation() << 0.15, 0.15, 0;
      prior.covariance.diagonal() << 1e-2, 1e-2, 1e-2, 1e-6, 4, 4;
    }
    const LidarOdometryResult result = odometry.align(sweep.points(), stamp(0.1 * k), step, &prior);
    odometry.add(sweep.points(), result);
    if (k < 2) continue;
    ASSERT_TRUE(result.usable()) << result.reason;
    const Eigen::Vector3d moved = result.motion.T_from_to.translation();
    EXPECT_GT(moved.x(), 0.04);
    EXPECT_LT(std::abs(moved.y()), 0.03);
  }
}

// After a sweep without a pose the prior would begin at a guess.
TEST(LidarOdometry, APriorIsNotUsedAfterASweepWithoutAPose) {
  LidarOdometry odometry(mounting());
  const Eigen::Isometry3d step = geometry::exp(0.1 * twist_per_second());
  const geometry::MotionBetween prior = measured_motion(step);
  for (int k = 0; k < 8; ++k) {
    const double seconds = 0.1 * k;
    const PointCloud sweep = k == 5 ? PointCloud()
                                    : random_room(static_cast<unsigned>(k + 1), kPoints, 0.02,
                                                  T_room_vehicle(seconds) * mounting());
    const LidarOdometryResult result = odometry.align(sweep.points(), stamp(seconds), step, &prior);
    odometry.add(sweep.points(), result);
    if (k < 6) continue;
    ASSERT_TRUE(result.usable()) << k << ": " << result.reason;
    const Eigen::Isometry3d T_map_vehicle = T_room_vehicle(0).inverse() * T_room_vehicle(seconds);
    EXPECT_LT((T_map_vehicle.inverse() * result.T_map_vehicle).translation().norm(), 0.06) << k;
  }
}

// Wheels that slip say too much: a room shows it.
TEST(LidarOdometry, AWrongPriorMovesLittleWhereTheGeometryShowsThePose) {
  LidarOdometry odometry(mounting());
  const Eigen::Isometry3d step = geometry::exp(0.1 * twist_per_second());
  const geometry::MotionBetween slipping =
      measured_motion(step * Eigen::Isometry3d(Eigen::Translation3d(0.2, 0, 0)));
  for (int k = 0; k < 8; ++k) {
    const double seconds = 0.1 * k;
    const PointCloud sweep = random_room(static_cast<unsigned>(k + 1), kPoints, 0.02,
                                         T_room_vehicle(seconds) * mounting());
    const LidarOdometryResult result =
        odometry.align(sweep.points(), stamp(seconds), slipping.T_from_to, &slipping);
    odometry.add(sweep.points(), result);
    if (k == 0) continue;
    ASSERT_TRUE(result.usable()) << k << ": " << result.reason;
    const geometry::Vector6 error = geometry::log(step.inverse() * result.motion.T_from_to);
    EXPECT_LT(error.head<3>().norm(), 5e-3) << k;
    EXPECT_LT(error.tail<3>().norm(), 0.06) << k;
  }
}

}  // namespace
}  // namespace infuse::registration
