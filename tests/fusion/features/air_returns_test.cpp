#include "fusion/features/air_returns.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace infuse::features {
namespace {

/// A sweep in a street, and which of its returns are of the air.
struct FoggySweep {
  Sweep sweep;
  std::vector<bool> is_air;
};

/// Range of a beam in a street between two walls, with a pole of 12 cm a side and a car: planes and
/// boxes, intersected exactly. 0: nothing.
double range_of_street(const Eigen::Vector3d& beam) {
  double nearest = 80;
  const auto hit_box = [&](const Eigen::Array3d& low, const Eigen::Array3d& high) {
    const Eigen::Array3d a = low / beam.array(), b = high / beam.array();
    const double enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
    if (enter > 0 && enter <= leave) nearest = std::min(nearest, enter);
  };
  hit_box({-100, -100, -3}, {100, 100, -1.9});  // ground
  hit_box({-100, 6, -2}, {100, 7, 6});
  hit_box({-100, -9, -2}, {100, -8, 6});
  hit_box({7, 3.0, -2}, {7.12, 3.12, 3});
  hit_box({-6, -4.5, -2}, {-1.8, -2.8, -0.5});
  return nearest < 80 ? nearest : 0;
}

/// A sweep of 32 rings of 1800 firings. The air returns a share of all pulses, and what met
/// nothing.
FoggySweep make_street(double air_share, uint32_t seed, bool ring_by_ring = false) {
  constexpr int kRings = 32, kColumns = 1800;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> noise(0, 0.02);
  FoggySweep out;
  out.sweep.rings = kRings;
  out.sweep.columns = kColumns;
  const auto add = [&](int ring, int column) {
    const double azimuth = -2 * std::numbers::pi * column / kColumns;
    const double elevation = (-30.7 + 1.33 * ring) * std::numbers::pi / 180;
    const Eigen::Vector3d beam(std::cos(elevation) * std::cos(azimuth),
                               std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    double range = range_of_street(beam);
    const double air = 1.5 - 3.5 * std::log(1 - uniform(random));
    const bool is_air = uniform(random) < air_share && (range == 0 || air < range);
    if (is_air) range = air;
    if (range == 0) return;
    range += noise(random);
    Sweep& s = out.sweep;
    const size_t i = s.size();
    s.resize(i + 1);
    s.x[i] = static_cast<float>(range * beam.x());
    s.y[i] = static_cast<float>(range * beam.y());
    s.z[i] = static_cast<float>(range * beam.z());
    s.range[i] = static_cast<float>(range);
    s.ring[i] = static_cast<uint16_t>(ring);
    s.column[i] = static_cast<uint16_t>(column);
    out.is_air.push_back(is_air);
  };
  out.sweep.reserve(kRings * kColumns);
  for (int a = 0; a < (ring_by_ring ? kRings : kColumns); ++a) {
    for (int b = 0; b < (ring_by_ring ? kColumns : kRings); ++b)
      ring_by_ring ? add(a, b) : add(b, a);
  }
  return out;
}

/// Shares of the near returns of the air and of surfaces that are left out.
struct LeftOut {
  double air = 0, surface = 0;
};

LeftOut leave_out(const FoggySweep& foggy, const AirReturnOptions& options = {}) {
  AirReturns filter(options);
  filter.find(foggy.sweep);
  const auto x = filter.without(foggy.sweep.x);
  double out[2] = {0, 0}, all[2] = {0, 0};
  for (size_t i = 0; i < x.size(); ++i) {
    if (foggy.sweep.range[i] > options.max_range) {
      EXPECT_EQ(x[i], foggy.sweep.x[i]);
      continue;
    }
    const size_t kind = foggy.is_air[i] ? 1 : 0;
    all[kind] += 1;
    out[kind] += std::isnan(x[i]) ? 1 : 0;
  }
  return {all[1] > 0 ? out[1] / all[1] : 0, out[0] / all[0]};
}

TEST(AirReturns, AreLeftOutOfFogAndSurfacesAreNot) {
  for (const double share : {0.1, 0.3}) {
    for (const bool ring_by_ring : {false, true}) {
      const LeftOut out = leave_out(make_street(share, 4, ring_by_ring));
      EXPECT_GT(out.air, 0.97) << share;
      EXPECT_LT(out.surface, 0.03) << share;
    }
  }
}

TEST(AirReturns, LeaveClearWeatherAsItIs) {
  const FoggySweep clear = make_street(0, 5), rain = make_street(0.01, 6);
  AirReturns filter;
  EXPECT_EQ(filter.find(clear.sweep), 0U);
  EXPECT_EQ(filter.without(clear.sweep.x).data(), clear.sweep.x.data());
  EXPECT_EQ(filter.find(rain.sweep), 0U);
  // Even without that rule nearly nothing stands alone.
  EXPECT_LT(leave_out(clear, {.min_share = 0}).surface, 0.005);
}

TEST(AirReturns, TwoEchoesOfAPulseAreNotNeighbours) {
  // Twenty pulses far from each other, each with two echoes at like ranges; and a wall.
  Sweep sweep;
  sweep.rings = 2;
  const auto add = [&](int ring, int column, float range) {
    const size_t i = sweep.size();
    sweep.resize(i + 1);
    const float azimuth = -0.003F * static_cast<float>(column);
    sweep.x[i] = range * std::cos(azimuth);
    sweep.y[i] = range * std::sin(azimuth);
    sweep.z[i] = 0;
    sweep.range[i] = range;
    sweep.ring[i] = static_cast<uint16_t>(ring);
    sweep.column[i] = static_cast<uint16_t>(column);
  };
  for (int k = 0; k < 20; ++k) {
    add(0, 20 * k, 4);
    add(0, 20 * k, 4.01F);
    for (int m = 0; m < 5; ++m) add(1, 20 * k + m, 4);
  }
  AirReturns filter({.min_neighbours = 1});
  EXPECT_EQ(filter.find(sweep), 0U) << "columns are not known";
  sweep.columns = 2000;
  EXPECT_EQ(filter.find(sweep), 40U);
  const auto x = filter.without(sweep.x);
  for (size_t i = 0; i < x.size(); ++i) EXPECT_EQ(std::isnan(x[i]), sweep.ring[i] == 0);
}

TEST(AirReturns, OptionsSayWhatIsWrong) {
  EXPECT_FALSE(AirReturnOptions{}.invalid());
  EXPECT_TRUE((AirReturnOptions{.columns = 0}).invalid());
  EXPECT_TRUE((AirReturnOptions{.min_neighbours = 9}).invalid());
  EXPECT_TRUE((AirReturnOptions{.min_share = 2}).invalid());
}

}  // namespace
}  // namespace infuse::features
