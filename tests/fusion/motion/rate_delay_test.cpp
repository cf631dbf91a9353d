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
TrueDrive road(double yaw_rate, double phase) {
  return TrueDrive(kRoadSeconds + 1, [=](double t) {
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
                       double delay, uint64_t seed) {
  SimulatedSensors lidar(by_lidar, seed), gyros(by_gyros, seed + 1000);
  std::mt19937_64 random(seed + 2000);
  std::normal_distribution<double> normal;
  const double scale = 1 + 0.01 * normal(random), phase = interval * (0.5 + 0.1 * normal(random));
  RateDelay found;
  double next = 0.4 + phase;
  for (double t = 0.1; t < kRoadSeconds; t += kSweepSeconds) {
    for (; next < t; next += interval) {
      const ImuSample sample = gyros.gyro(next - delay, {0.02, -0.01, 0.03});
      found.add(seconds(next),
                scale * Eigen::Map<const Eigen::Vector3d>(sample.angular_velocity.data()));
    }
    if (t > 0.2) found.add(lidar.lidar(t - kSweepSeconds, t));
  }
  return found.found();
}

// Thirty drives at each rate, late and early. The standard deviation of the mean square of thirty
// normal numbers is 0.26.
TEST(RateDelay, IsFoundWithItsSigma) {
  for (const double interval : {0.1, 0.01}) {
    double normalised = 0, square = 0;
    int count = 0;
    for (uint64_t seed = 1; seed <= 30; ++seed) {
      std::mt19937_64 random(seed);
      const double delay = std::uniform_real_distribution<double>(-0.1, 0.15)(random);
      const double turns = std::uniform_real_distribution<double>(0.1, 0.5)(random);
      const TrueDrive drive = road(turns, static_cast<double>(seed));
      const SensorDelay found = find_delay(drive, drive, interval, delay, seed);
      ASSERT_TRUE(found.usable()) << found.reason;
      EXPECT_NEAR(found.value, delay, 0.015) << interval;
      normalised += std::pow((found.value - delay) / found.sigma, 2);
      square += std::pow(found.value - delay, 2);
      ++count;
    }
    std::cout << interval << " s: rms " << 1e3 * std::sqrt(square / count) << " ms, normalised "
              << normalised / count << "\n";
    EXPECT_LT(normalised / count, 2) << interval;
    EXPECT_GT(normalised / count, 0.5) << interval;
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
