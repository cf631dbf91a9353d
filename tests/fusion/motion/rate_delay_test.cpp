#include "fusion/motion/rate_delay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::motion {
namespace {

constexpr double kSweepSeconds = 0.1, kRoadSeconds = 45;  // s

/// A road that turns by up to `yaw_rate`, and shakes.
TrueDrive road(double yaw_rate, double phase, double length = kRoadSeconds) {
  return TrueDrive(length + 1, [=](double t) {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[0] = 0.01 * std::sin(7 * t + phase);
    twist[1] = 0.01 * std::sin(9 * t + 2 * phase);
    twist[2] = yaw_rate * std::pow(std::sin(0.35 * t + phase), 3);
    twist[3] = 9 + 4 * std::sin(0.5 * t + phase);
    return twist;
  });
}

/// Motions of `by_lidar` beside the rates of `by_gyros`, every `interval` s, of which each axis has
/// a bias and a wrong scale.
SensorDelay find_delay(const TrueDrive& by_lidar, const TrueDrive& by_gyros, double interval,
                       double delay, uint64_t seed, double length = kRoadSeconds) {
  SimulatedSensors lidar(by_lidar, seed), gyros(by_gyros, seed + 1000);
  std::mt19937_64 random(seed + 2000);
  std::normal_distribution<double> normal;
  const double scale = 1 + 0.01 * normal(random), phase = interval * (0.5 + 0.1 * normal(random));
  RateDelay found;
  double next = 0.2 + phase;
  for (double t = 0.1; t < length; t += kSweepSeconds) {
    for (; next < t; next += interval) {
      const ImuSample sample = gyros.gyro(next - delay, {0.02, -0.01, 0.03});
      found.add(seconds(next),
                scale * Eigen::Map<const Eigen::Vector3d>(sample.angular_velocity.data()));
    }
    if (t > 0.2) found.add(lidar.lidar(t - kSweepSeconds, t));
  }
  return found.finish();
}

/// rms of the errors, s, and their mean square over the stated variance, of drives with delays,
/// late and early, and bends that are drawn. Drives that do not show the delay are left out, but
/// not all.
struct Found {
  double rms = 0, normalised = 0;
  int usable = 0;
};

Found find_in_drives(int drives, double interval, double length) {
  Found found;
  for (int seed = 1; seed <= drives; ++seed) {
    std::mt19937_64 random(static_cast<uint64_t>(seed));
    const double delay = std::uniform_real_distribution<double>(-0.1, 0.15)(random);
    const double turns = std::uniform_real_distribution<double>(0.1, 0.5)(random);
    const TrueDrive drive = road(turns, seed, length);
    const SensorDelay one =
        find_delay(drive, drive, interval, delay, static_cast<uint64_t>(seed), length);
    if (!one.usable()) continue;
    ++found.usable;
    found.rms += std::pow(one.value - delay, 2);
    found.normalised += std::pow((one.value - delay) / one.sigma, 2);
  }
  found.rms = std::sqrt(found.rms / found.usable);
  found.normalised /= found.usable;
  return found;
}

// At the rates of a bus and of an inertial unit, and for the five seconds of a short recording. The
// standard deviation of the mean square of thirty normal numbers is 0.26.
TEST(RateDelay, IsFoundWithItsSigma) {
  struct Case {
    int drives;
    double interval, length, rms;
  };
  for (const Case& drawn : {Case{30, 0.1, kRoadSeconds, 0.003},
                            {30, 0.01, kRoadSeconds, 0.003},
                            {60, 0.1, 5.3, 0.010}}) {
    const Found found = find_in_drives(drawn.drives, drawn.interval, drawn.length);
    std::cout << drawn.interval << " s, " << drawn.length << " s: " << found.usable
              << " drives, rms " << 1e3 * found.rms << " ms, normalised " << found.normalised
              << "\n";
    EXPECT_GE(found.usable, 30) << drawn.interval << " " << drawn.length;
    EXPECT_LT(found.rms, drawn.rms) << drawn.interval << " " << drawn.length;
    EXPECT_LT(found.normalised, 2) << drawn.interval << " " << drawn.length;
    EXPECT_GT(found.normalised, 0.4) << drawn.interval << " " << drawn.length;
  }
}

TEST(RateDelay, IsNotStatedWhereNothingShowsIt) {
  const TrueDrive drive = road(0.35, 0), other = road(0.35, 1.5);
  const TrueDrive still(kRoadSeconds + 1,
                        [](double) { return geometry::Vector6(geometry::Vector6::Zero()); });
  EXPECT_FALSE(find_delay(still, still, 0.01, 0.07, 1).usable());
  EXPECT_FALSE(find_delay(drive, drive, 0.01, 0.4, 1).usable()) << "outside what is searched";
  EXPECT_FALSE(find_delay(drive, still, 0.01, 0, 1).usable()) << "gyros that measure nothing";
  EXPECT_FALSE(find_delay(other, drive, 0.01, 0, 1).usable()) << "of another vehicle";
  EXPECT_FALSE(RateDelay().found().usable());
}

}  // namespace
}  // namespace infuse::motion
