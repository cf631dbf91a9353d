#include "fusion/motion/deskew.hpp"
#include "drivers/measurement/angles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fusion/motion/odometry_filter.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/fusion/motion/true_drive.hpp"

namespace infuse::motion {
namespace {

using geometry::Trajectory;
using geometry::Vector6;

Eigen::Isometry3d T_vehicle_lidar() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 1.2, 0.1, 1.73;
  T.linear() = geometry::rotation_exp({0.01, -0.02, 0.03});
  return T;
}

/// About 15 m/s and 30°/s, neither constant, with some pitch and roll.
Vector6 varying_twist(double t) {
  Vector6 twist;
  twist << 0.04 * std::sin(9 * t), 0.05 * std::cos(7 * t), 0.5236 * (1 + 0.2 * std::sin(3 * t)),
      15 + 1.5 * std::sin(2 * t), 0, 0;
  return twist;
}

/// Trajectory with a pose every 10 ms of the true drive.
Trajectory true_trajectory(const TrueDrive& drive) {
  Trajectory trajectory;
  for (int i = 0; 0.01 * i <= drive.seconds(); ++i) {
    trajectory.append({seconds(0.01 * i), drive.pose(0.01 * i), geometry::Matrix6::Zero()});
  }
  return trajectory;
}

Sweep random_sweep(size_t returns, double start, uint64_t seed, bool ordered) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> place(-120, 120);
  std::uniform_int_distribution<int32_t> any_time(0, 100'000'000);
  Sweep sweep;
  sweep.resize(returns);
  sweep.stamp = seconds(start);
  sweep.span = Duration(100'000'000);
  for (size_t i = 0; i < returns; ++i) {
    sweep.x[i] = place(random);
    sweep.y[i] = place(random);
    sweep.z[i] = place(random) / 10;
    sweep.time_offset_ns[i] = ordered ? static_cast<int32_t>(100'000'000 * static_cast<int64_t>(i) /
                                                             static_cast<int64_t>(returns)) -
                                            static_cast<int32_t>(i % 7) * 50
                                      : any_time(random);
  }
  return sweep;
}

/// Largest distance of a return from its exact position, by exp and log for each return.
double max_error(const Sweep& sweep, const Trajectory& trajectory, Stamp reference,
                 const DeskewedSweep& deskewed) {
  const Eigen::Isometry3d T_reference_odom =
      (trajectory.at(reference).T_odom_vehicle * T_vehicle_lidar()).inverse();
  double max = 0;
  for (size_t i = 0; i < sweep.size(); ++i) {
    const auto pose = trajectory.at(sweep.stamp + Duration(sweep.time_offset_ns[i]));
    const Eigen::Vector3d exact = T_reference_odom * pose.T_odom_vehicle * T_vehicle_lidar() *
                                  Eigen::Vector3d(sweep.x[i], sweep.y[i], sweep.z[i]);
    const Eigen::Vector3d got(deskewed.x[i], deskewed.y[i], deskewed.z[i]);
    max = std::max(max, (got - exact).norm());
  }
  return max;
}

TEST(Deskew, AgreesWithAnExactPoseForEachReturn) {
  const TrueDrive drive(1, varying_twist);
  const Trajectory trajectory = true_trajectory(drive);
  Deskewer deskewer(T_vehicle_lidar());
  DeskewedSweep deskewed;
  for (const bool ordered : {true, false}) {
    const Sweep sweep = random_sweep(20011, 0.503, 1, ordered);
    for (const Stamp reference : {sweep.stamp, sweep.stamp + sweep.span, seconds(0.6312)}) {
      deskewer.deskew(sweep, trajectory, reference, deskewed);
      ASSERT_TRUE(deskewed.usable()) << deskewed.reason;
      EXPECT_EQ(deskewed.reference, reference);
      // 0.1 mm by the bound of the cells, the rest is single precision at 170 m.
      EXPECT_LT(max_error(sweep, trajectory, reference, deskewed), 2e-4);
    }
    EXPECT_NEAR(deskewed.motion.T_from_to.translation().x(), 1.5, 0.2);
  }
}

TEST(Deskew, KeepsItsToleranceWhenTheVehicleSpins) {
  // 170°/s and poses only every 100 ms: finer cells are needed for the tolerance.
  Trajectory trajectory;
  Vector6 step;
  step << 0.02, 0.01, 0.3, 2, 0, 0;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 6; ++i, T = T * geometry::exp(step)) {
    trajectory.append({seconds(0.1 * i), T, geometry::Matrix6::Zero()});
  }
  const Sweep sweep = random_sweep(20011, 0.25, 2, true);
  for (const double tolerance : {1e-4, 1e-2, 1.0}) {
    DeskewOptions options;
    options.tolerance = tolerance;
    Deskewer deskewer(T_vehicle_lidar(), options);
    DeskewedSweep deskewed;
    deskewer.deskew(sweep, trajectory, sweep.stamp, deskewed);
    ASSERT_TRUE(deskewed.usable());
    const double max = max_error(sweep, trajectory, sweep.stamp, deskewed);
    EXPECT_LT(max, tolerance + 1e-4);
    if (tolerance == 1e-2) {
      EXPECT_GT(max, 5e-4) << "coarser cells must exceed the tolerance";
    }
  }
}

TEST(Deskew, CopiesReturnsThatOdometryDoesNotCover) {
  const TrueDrive drive(1, varying_twist);
  const Trajectory trajectory = true_trajectory(drive);
  Deskewer deskewer(T_vehicle_lidar());
  DeskewedSweep deskewed;
  const auto expect_not_deskewed = [&](const Sweep& sweep, const Trajectory& known, Stamp reference,
                                       const char* reason) {
    deskewer.deskew(sweep, known, reference, deskewed);
    EXPECT_STREQ(deskewed.reason, reason);
    EXPECT_FALSE(deskewed.usable());
    EXPECT_TRUE(std::equal(sweep.x.begin(), sweep.x.end(), deskewed.x.begin(), deskewed.x.end()));
    EXPECT_TRUE(std::equal(sweep.z.begin(), sweep.z.end(), deskewed.z.begin(), deskewed.z.end()));
  };
  Sweep sweep = random_sweep(1000, 0.95, 3, true);
  expect_not_deskewed(sweep, trajectory, sweep.stamp, "the time is after the last pose");
  expect_not_deskewed(sweep, Trajectory(), sweep.stamp, "the trajectory is empty");
  sweep.stamp = seconds(-0.01);
  expect_not_deskewed(sweep, trajectory, seconds(0.5), "the time is before the first pose");
  sweep.stamp = seconds(0.5);
  expect_not_deskewed(sweep, trajectory, seconds(1.2), "the time is after the last pose");
  Trajectory gap;
  for (const double t : {0.1, 0.9}) {
    geometry::StampedPose pose;
    pose.stamp = seconds(t);
    gap.append(pose);
  }
  expect_not_deskewed(sweep, gap, sweep.stamp, "the poses around the time are too far apart");
  sweep.has_times = false;
  expect_not_deskewed(sweep, trajectory, sweep.stamp, "the sweep has no time for each return");
  sweep.has_times = true;
  Trajectory absurd;
  for (int i = 0; i < 12; ++i) {
    geometry::StampedPose pose;
    pose.stamp = seconds(0.1 * i);
    pose.T_odom_vehicle.translation().x() = i % 2 == 0 ? 1e12 : 0;
    pose.T_odom_vehicle.linear() = geometry::rotation_exp({0, 0, i % 2 == 0 ? 3.0 : 0.0});
    absurd.append(pose);
  }
  expect_not_deskewed(sweep, absurd, sweep.stamp, "the motion is too fast to deskew");
}

TEST(Deskew, AcceptsEmptyAndSingleReturnSweeps) {
  const TrueDrive drive(1, varying_twist);
  const Trajectory trajectory = true_trajectory(drive);
  Deskewer deskewer(T_vehicle_lidar());
  DeskewedSweep deskewed;
  Sweep sweep;
  sweep.stamp = seconds(0.5);
  deskewer.deskew(sweep, trajectory, sweep.stamp, deskewed);
  EXPECT_TRUE(deskewed.usable());
  EXPECT_TRUE(deskewed.x.empty());
  for (const double start : {0.5, 0.503, 1.0}) {  // on a pose, between two, on the last
    sweep = random_sweep(1, start, 4, true);
    sweep.time_offset_ns[0] = 0;
    deskewer.deskew(sweep, trajectory, seconds(0.7), deskewed);
    ASSERT_TRUE(deskewed.usable()) << deskewed.reason;
    EXPECT_LT(max_error(sweep, trajectory, seconds(0.7), deskewed), 1e-4);
  }
}

// For any alignment, in the vector body or the scalar tail: a return gives the same bytes.
TEST(Deskew, DoesNotDependOnTheGroupingOfReturns) {
  const TrueDrive drive(1, varying_twist);
  const Trajectory trajectory = true_trajectory(drive);
  Deskewer deskewer(T_vehicle_lidar());
  const Sweep sweep = random_sweep(999, 0.5, 5, true);
  DeskewedSweep whole, part;
  deskewer.deskew(sweep, trajectory, sweep.stamp, whole);
  Sweep shuffled = sweep;  // the same returns in another order, first and last kept
  for (size_t i = 1; i + 1 < sweep.size(); ++i) {
    const size_t from = 1 + (i * 421) % (sweep.size() - 2);
    shuffled.x[i] = sweep.x[from];
    shuffled.y[i] = sweep.y[from];
    shuffled.z[i] = sweep.z[from];
    shuffled.time_offset_ns[i] = sweep.time_offset_ns[from];
  }
  deskewer.deskew(shuffled, trajectory, sweep.stamp, part);
  for (size_t i = 1; i + 1 < sweep.size(); ++i) {
    const size_t from = 1 + (i * 421) % (sweep.size() - 2);
    EXPECT_EQ(part.x[i], whole.x[from]);
    EXPECT_EQ(part.y[i], whole.y[from]);
    EXPECT_EQ(part.z[i], whole.z[from]);
  }
}

TEST(Deskew, DoesNotAllocateAfterWarmUp) {
  if (!kAllocationsCounted) GTEST_SKIP() << "the sanitizer has its own allocator";
  const TrueDrive drive(2, varying_twist);
  const Trajectory trajectory = true_trajectory(drive);
  Deskewer deskewer(T_vehicle_lidar());
  DeskewedSweep deskewed;
  const Sweep first = random_sweep(5000, 0.5, 6, true), second = random_sweep(4000, 1.1, 7, false);
  deskewer.deskew(first, trajectory, first.stamp, deskewed);
  OdometryFilter filter;
  filter.add(drive.wheels(0));
  const size_t before = allocation_count();
  deskewer.deskew(second, trajectory, second.stamp, deskewed);
  deskewer.deskew(first, trajectory, seconds(3), deskewed);
  for (int i = 1; i < 100; ++i) filter.add(drive.wheels(0.01 * i));
  filter.flush();
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(filter.trajectory().size(), 90u);
}

// --- planar scene, a sweep like an HDL-64E's, and the truth in closed form ---

struct Plane {
  Eigen::Vector3d normal;
  double distance;  // normal · p = distance
};

/// A street at a crossing: ground, house fronts, walls across the road further away.
const std::vector<Plane>& world() {
  static const std::vector<Plane> planes = {
      {Eigen::Vector3d::UnitZ(), 0},   {Eigen::Vector3d::UnitY(), 45},
      {Eigen::Vector3d::UnitY(), -25}, {Eigen::Vector3d(0.9, -0.1, 0.05).normalized(), 75},
      {Eigen::Vector3d::UnitX(), -60},
  };
  return planes;
}

struct SimulatedSweep {
  Sweep measured;
  std::vector<Eigen::Vector3d> hits;  // odometry frame, without range noise
};

SimulatedSweep simulate_sweep(const TrueDrive& drive, double start, double range_noise,
                              uint64_t seed) {
  constexpr size_t kRings = 64, kColumns = 900;
  constexpr double kSweepSeconds = 0.1;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, range_noise);
  SimulatedSweep made;
  made.measured.reserve(kRings * kColumns);
  made.measured.stamp = seconds(start);
  made.measured.span = seconds(kSweepSeconds) - seconds(0);
  for (size_t column = 0; column < kColumns; ++column) {
    const auto offset =
        static_cast<int32_t>(1e9 * kSweepSeconds * static_cast<double>(column) / kColumns);
    const Eigen::Isometry3d T_map_lidar = drive.pose(start + 1e-9 * offset) * T_vehicle_lidar();
    const double azimuth = -2 * std::numbers::pi * static_cast<double>(column) / kColumns;
    for (size_t ring = 0; ring < kRings; ++ring) {
      const double elevation = (-24.8 + 26.8 * static_cast<double>(ring) / (kRings - 1)) * kDegree;
      const Eigen::Vector3d beam(std::cos(elevation) * std::cos(azimuth),
                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Eigen::Vector3d from = T_map_lidar.translation(), along = T_map_lidar.linear() * beam;
      double range = 1e9;
      for (const Plane& plane : world()) {
        const double at = (plane.distance - plane.normal.dot(from)) / plane.normal.dot(along);
        if (at > 0.5) range = std::min(range, at);
      }
      if (range > 120) continue;
      const size_t i = made.hits.size();
      made.hits.push_back(from + range * along);
      made.measured.resize(i + 1);
      const Eigen::Vector3d point = (range + noise(random)) * beam;
      made.measured.x[i] = static_cast<float>(point.x());
      made.measured.y[i] = static_cast<float>(point.y());
      made.measured.z[i] = static_cast<float>(point.z());
      made.measured.time_offset_ns[i] = offset;
    }
  }
  return made;
}

struct Residual {
  double rms = 0;  // beyond the range noise
  double max = 0;  // of the raw returns: at the far end
};

Residual residual(const SimulatedSweep& sweep, const TrueDrive& drive, double reference,
                  double range_noise, const FieldVector<float>& x, const FieldVector<float>& y,
                  const FieldVector<float>& z) {
  const Eigen::Isometry3d T_lidar_map = (drive.pose(reference) * T_vehicle_lidar()).inverse();
  double sum = 0, max = 0;
  for (size_t i = 0; i < sweep.hits.size(); ++i) {
    const Eigen::Vector3d error = Eigen::Vector3d(x[i], y[i], z[i]) - T_lidar_map * sweep.hits[i];
    sum += error.squaredNorm();
    max = std::max(max, error.norm());
  }
  const double mean = sum / static_cast<double>(sweep.hits.size());
  return {std::sqrt(std::max(0.0, mean - range_noise * range_noise)), max};
}

/// Planar motion: 15 m/s and 30°/s, both varying.
Vector6 turning_twist(double t) {
  Vector6 twist = Vector6::Zero();
  twist[2] = 0.5236 * (1 + 0.15 * std::sin(2 * t));
  twist[3] = 15 + 0.8 * std::sin(1.3 * t);
  return twist;
}

TEST(Deskew, TurningHdl64WithPerfectOdometry) {
  constexpr double kRangeNoise = 0.02;
  const TrueDrive drive(1, varying_twist);
  const Trajectory trajectory = true_trajectory(drive);
  const SimulatedSweep sweep = simulate_sweep(drive, 0.4, kRangeNoise, 1);
  ASSERT_GT(sweep.hits.size(), 30000u);
  Deskewer deskewer(T_vehicle_lidar());
  DeskewedSweep deskewed;
  for (const double reference : {0.5, 0.4, 0.437}) {
    deskewer.deskew(sweep.measured, trajectory, seconds(reference), deskewed);
    ASSERT_TRUE(deskewed.usable());
    const Residual after =
        residual(sweep, drive, reference, kRangeNoise, deskewed.x, deskewed.y, deskewed.z);
    EXPECT_LT(after.rms, 0.02) << reference;
    const Sweep& raw = sweep.measured;
    const Residual before = residual(sweep, drive, reference, kRangeNoise, raw.x, raw.y, raw.z);
    EXPECT_GT(before.max, 1.0) << reference;
    EXPECT_GT(before.rms, 10 * after.rms);
    RecordProperty("rms_mm", static_cast<int>(1e3 * after.rms));
  }
}

// A typical CAN bus: wheel speeds at 50 Hz in steps of 0.01 km/h with a scale error of 0.4 % and
// noise, yaw rate at 50 Hz in steps of 0.244°/s with a bias of 0.4°/s; the car stands for 3 s,
// starts and turns.
TEST(Deskew, TurningHdl64WithCanOdometry) {
  constexpr double kRangeNoise = 0.02;
  const TrueDrive drive(16, [](double t) {
    const double start = std::clamp((t - 3) / 5, 0.0, 1.0);
    return Vector6(turning_twist(t) * start * start * (3 - 2 * start));
  });
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  OdometryFilter filter;
  std::vector<std::pair<double, SimulatedSweep>> sweeps;
  for (const double start : {9.0, 11.53, 14.271}) {
    sweeps.emplace_back(start, simulate_sweep(drive, start, kRangeNoise, 3));
  }
  for (double t = 0; t < 15.9; t += 0.02) {
    WheelOdometry sample = drive.wheels(t);
    for (double& speed : sample.wheel_speed) {
      if (speed != 0) speed = speed / 1.004 + 0.03 * normal(random);
      speed = std::round(speed * 360) / 360;
    }
    constexpr double kYawRateStep = 0.244 * kDegree;
    const double bias = 0.4 * kDegree;
    sample.yaw_rate =
        std::round((sample.yaw_rate + bias + 0.003 * normal(random)) / kYawRateStep) * kYawRateStep;
    filter.add(sample);
  }
  filter.flush();
  ASSERT_TRUE(filter.usable()) << filter.reason();
  Deskewer deskewer(T_vehicle_lidar());
  DeskewedSweep deskewed;
  for (const auto& [start, sweep] : sweeps) {
    deskewer.deskew(sweep.measured, filter.trajectory(), seconds(start + 0.1), deskewed);
    ASSERT_TRUE(deskewed.usable()) << deskewed.reason;
    const Residual after =
        residual(sweep, drive, start + 0.1, kRangeNoise, deskewed.x, deskewed.y, deskewed.z);
    EXPECT_LT(after.rms, 0.05) << start;
    const Sweep& raw = sweep.measured;
    EXPECT_GT(residual(sweep, drive, start + 0.1, kRangeNoise, raw.x, raw.y, raw.z).max, 1.0);
    RecordProperty("rms_mm", static_cast<int>(1e3 * after.rms));
  }
}

}  // namespace
}  // namespace infuse::motion
