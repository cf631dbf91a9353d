#include "fusion/motion/gyro_axes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/allocation_counter.hpp"
#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::motion {
namespace {

/// Three gyros in a housing: signed axes, biases and noise as of real HDL-32E captures, of which
/// one has a bias of 30 degrees a second.
struct Housing {
  std::array<int, 3> axis{0, 1, 2};
  std::array<double, 3> sign{1, 1, 1};
  std::array<double, 3> bias{};
  std::array<double, 3> scale{1, 1, 1};
  Eigen::Matrix3d R_vehicle_lidar = Eigen::Matrix3d::Identity();
  double noise = 0.02;  // rad/s

  static Housing draw(uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Housing out;
    std::shuffle(out.axis.begin(), out.axis.end(), random);
    for (size_t i = 0; i < 3; ++i) {
      out.sign[i] = uniform(random) < 0 ? -1 : 1;
      out.bias[i] = 0.5 * uniform(random);
    }
    out.R_vehicle_lidar = (Eigen::AngleAxisd(3.1 * uniform(random), Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(0.3 * uniform(random), Eigen::Vector3d::UnitY()))
                              .matrix();
    return out;
  }
};

/// Body rates of a car in a town.
TrueDrive car(double length, double roll, double pitch, double yaw) {
  return TrueDrive(length, [=](double t) {
    geometry::Vector6 twist;
    twist << roll * std::sin(5.1 * t), pitch * std::sin(6.3 * t + 1), yaw * std::sin(0.5 * t), 0, 0,
        0;
    twist[3] = 10;
    return twist;
  });
}

/// Drives, with readings at 200 Hz and sweeps at 10 Hz; calls `after_sweep(t)`.
template <class AfterSweep>
void drive_with(const TrueDrive& drive, const Housing& housing, uint64_t seed, GyroAxes& axes,
                AfterSweep after_sweep, double begin = 0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, housing.noise);
  SimulatedSensors sensors(drive, seed);
  for (int i = 1; i * 0.005 < drive.seconds() - 0.1; ++i) {
    const double t = 0.005 * i;
    const Eigen::Vector3d rate = housing.R_vehicle_lidar.transpose() * drive.twist(t).head<3>();
    GyroReadings readings{seconds(begin + t), {}};
    for (size_t g = 0; g < 3; ++g) {
      readings.rate[g] = housing.scale[g] * housing.sign[g] * rate[housing.axis[g]] +
                         housing.bias[g] + normal(random);
    }
    axes.add(readings);
    if (i % 20 != 0) continue;
    RelativePose motion = sensors.lidar(t - 0.1, t);
    motion.from = seconds(begin + t - 0.1);
    motion.to = seconds(begin + t);
    axes.add(motion);
    after_sweep(t);
  }
}

/// Number of known axes; fails if one of them is wrong.
int count_right(const GyroAxes& axes, const Housing& housing) {
  int known = 0;
  for (size_t g = 0; g < 3; ++g) {
    const GyroAxis& axis = axes.axes()[g];
    if (!axis.known()) continue;
    ++known;
    EXPECT_EQ(axis.axis, housing.axis[g]);
    EXPECT_EQ(axis.sign, housing.sign[g]);
    EXPECT_NEAR(axis.bias, housing.bias[g], 0.006);
    EXPECT_GT(axis.noise, 0.8 * housing.noise);
    EXPECT_LT(axis.noise, 2 * housing.noise);
  }
  return known;
}

TEST(GyroAxes, AreFoundHoweverTheyArePermuted) {
  const TrueDrive drive = car(30, 0.05, 0.04, 0.3);
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    const Housing housing = Housing::draw(seed);
    GyroAxes axes(housing.R_vehicle_lidar);
    int known = 0;
    drive_with(drive, housing, seed, axes, [&](double) { known = count_right(axes, housing); });
    EXPECT_EQ(known, 3) << seed;
  }
}

TEST(GyroAxes, MeasureTheVehiclesRotation) {
  const TrueDrive drive = car(40, 0.05, 0.04, 0.3);
  const Housing housing = Housing::draw(7);
  GyroAxes axes(housing.R_vehicle_lidar);
  drive_with(drive, housing, 7, axes, [](double) {});
  ASSERT_EQ(count_right(axes, housing), 3);
  // Without noise: what is left is the error of the biases.
  for (const double t : {3.0, 11.0, 17.0}) {
    const Eigen::Vector3d truth = drive.twist(t).head<3>();
    const Eigen::Vector3d rate = housing.R_vehicle_lidar.transpose() * truth;
    GyroReadings readings{seconds(t), {}};
    for (size_t g = 0; g < 3; ++g) {
      readings.rate[g] = housing.sign[g] * rate[housing.axis[g]] + housing.bias[g];
    }
    const auto sample = axes.measure(readings);
    ASSERT_TRUE(sample);
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(sample->value[i], truth[static_cast<int>(i)], 0.006);
    }
  }
}

TEST(GyroAxes, AVehicleThatOnlyTurnsShowsTheGyroAboutZ) {
  Housing housing = Housing::draw(3);
  housing.R_vehicle_lidar.setIdentity();
  GyroAxes axes(housing.R_vehicle_lidar);
  drive_with(car(60, 0, 0, 0.3), housing, 3, axes, [](double) {});
  EXPECT_EQ(count_right(axes, housing), 1);
  const auto sample = axes.measure({seconds(61), {}});
  ASSERT_TRUE(sample);
  EXPECT_TRUE(std::isnan(sample->value[0]));
  EXPECT_TRUE(std::isnan(sample->value[1]));
  EXPECT_TRUE(std::isfinite(sample->value[2]));
  // On its side, the lidar's z axis is not the vehicle's.
  GyroAxes lying(Eigen::AngleAxisd(1.57, Eigen::Vector3d::UnitX()).matrix());
  housing.R_vehicle_lidar = Eigen::AngleAxisd(1.57, Eigen::Vector3d::UnitX()).matrix();
  drive_with(car(60, 0, 0.05, 0), housing, 3, lying, [](double) {});
  EXPECT_EQ(count_right(lying, housing), 1);
  EXPECT_FALSE(lying.measure({seconds(61), {}}));
}

TEST(GyroAxes, NothingIsKnownWithoutMotionOrFromOtherSensors) {
  const auto known = [](const TrueDrive& drive, const Housing& housing) {
    GyroAxes axes(housing.R_vehicle_lidar);
    int most = 0;
    drive_with(drive, housing, 5, axes, [&](double) {
      int count = 0;
      for (const GyroAxis& axis : axes.axes()) count += axis.known();
      most = std::max(most, count);
    });
    return most;
  };
  const TrueDrive straight = car(40, 0, 0, 0), still = car(40, 0.002, 0.002, 0.002);
  const TrueDrive town = car(40, 0.05, 0.04, 0.3);
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_EQ(known(straight, Housing::draw(seed)), 0);
    EXPECT_EQ(known(still, Housing::draw(seed)), 0);
  }
  Housing dead = Housing::draw(1);
  dead.scale = {0, 0, 0};
  dead.noise = 0;
  EXPECT_EQ(known(town, dead), 0);
  dead.noise = 0.02;
  EXPECT_EQ(known(town, dead), 0);
  Housing wrong = Housing::draw(1);
  wrong.scale = {1.4, 1.4, 1.4};
  EXPECT_EQ(known(town, wrong), 0);
  Housing twice = Housing::draw(1);
  twice.axis = {2, 2, 2};
  EXPECT_LE(known(town, twice), 1);
}

TEST(GyroAxes, AWrongAxisIsGivenUp) {
  Housing before = Housing::draw(2), after = Housing::draw(2);
  after.sign[0] = -before.sign[0];
  GyroAxes axes(before.R_vehicle_lidar, {.memory = Duration(30'000'000'000)});
  const TrueDrive drive = car(40, 0.05, 0.04, 0.3);
  drive_with(drive, before, 1, axes, [](double) {});
  ASSERT_EQ(count_right(axes, before), 3);
  double given_up = 0;
  drive_with(
      car(130, 0.05, 0.04, 0.3), after, 2, axes,
      [&](double t) {
        if (given_up == 0 && !axes.axes()[0].known()) given_up = t;
      },
      40);
  EXPECT_GT(given_up, 0);
  EXPECT_LT(given_up, 60);
  EXPECT_TRUE(axes.axes()[0].known());
  EXPECT_EQ(axes.axes()[0].sign, after.sign[0]);
}

TEST(GyroAxes, DoNotAllocate) {
  const Housing housing = Housing::draw(4);
  GyroAxes axes(housing.R_vehicle_lidar);
  const TrueDrive drive = car(10, 0.05, 0.04, 0.3);
  RelativePose motion;
  motion.from = seconds(0.9);
  motion.to = seconds(1);
  motion.information = 1e8 * geometry::Matrix6::Identity();
  const size_t before = allocation_count();
  for (int i = 0; i < 1000; ++i) {
    axes.add(GyroReadings{seconds(0.005 * i), {0.1, 0.2, 0.3}});
    motion.to = seconds(0.005 * i);
    motion.from = motion.to - from_seconds(0.1);
    axes.add(motion);
  }
  EXPECT_EQ(allocation_count(), before);
}

TEST(GyroAxes, OptionsAreChecked) {
  EXPECT_FALSE(GyroAxesOptions().invalid());
  EXPECT_TRUE(GyroAxesOptions{.memory = Duration(0)}.invalid());
  EXPECT_TRUE(GyroAxesOptions{.min_lead = -1}.invalid());
  EXPECT_TRUE(GyroAxesOptions{.max_unexplained = 2}.invalid());
}

}  // namespace
}  // namespace infuse::motion
