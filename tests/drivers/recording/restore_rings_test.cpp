#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

#include "drivers/measurement/angles.hpp"
#include "drivers/recording/pcd_sweep.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/text/text_file.hpp"
#include "tests/real_data.hpp"

namespace infuse::recording {
namespace {

// Elevations of beams, degrees, from below.
std::vector<double> even_beams(int beams, double low, double high) {
  std::vector<double> all;
  for (int k = 0; k < beams; ++k) all.push_back(low + (high - low) * k / (beams - 1));
  return all;
}

// Uneven, as far-looking lidars have them: 0.33 degrees apart near the horizon, up to 3 elsewhere.
const std::vector<double> kUnevenBeams = {
    -25,  -15.6, -11.3, -8.8, -7.3, -6.1, -5.3, -4.7, -4,  -3.7, -3.3, -3,  -2.7, -2.3, -2,   -1.7,
    -1.3, -1,    -0.7,  -0.3, 0,    0.3,  0.7,  1,    1.3, 1.7,  2.3,  3.3, 4.7,  7,    10.3, 15};

// Road 1.8 m below and facades around a lidar, points in random order; open sky above 40 m. The
// beam is kept as the point's reflectivity.
Sweep shuffled_cloud(const std::vector<double>& beams, int columns, double noise, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1; };
  struct Made {
    double x, y, z;
    size_t beam;
  };
  std::vector<Made> made;
  for (size_t b = 0; b < beams.size(); ++b) {
    for (int c = 0; c < columns; ++c) {
      const double azimuth = 2 * M_PI * (c + 0.4) / columns;
      const double sine = std::sin(beams[b] * kDegree);
      double range = 14 + 8 * std::sin(3 * azimuth) + (c % 90 < 20 ? 15 : 0);
      if (sine < 0) range = std::min(range, -1.8 / sine);
      if (range * sine > 4) continue;
      range += noise * uniform();
      const double flat = range * std::cos(beams[b] * kDegree);
      made.push_back({flat * std::cos(azimuth), flat * std::sin(azimuth), range * sine, b});
    }
  }
  for (size_t k = made.size(); k > 1; --k) std::swap(made[k - 1], made[random() % k]);
  Sweep sweep;
  sweep.resize(made.size());
  for (size_t i = 0; i < made.size(); ++i) {
    sweep.x[i] = static_cast<float>(made[i].x);
    sweep.y[i] = static_cast<float>(made[i].y);
    sweep.z[i] = static_cast<float>(made[i].z);
    sweep.range[i] = static_cast<float>(std::hypot(made[i].x, made[i].y, made[i].z));
    sweep.reflectivity[i] = static_cast<float>(made[i].beam);
    sweep.ring[i] = sweep.column[i] = 0;
    sweep.time_offset_ns[i] = 0;
    sweep.return_kind[i] = ReturnKind::kStrongest;
  }
  return sweep;
}

void expect_true_rings(const std::vector<double>& beams, int columns, double noise) {
  Sweep sweep = shuffled_cloud(beams, columns, noise, 1);
  const std::set<float> seen(sweep.reflectivity.begin(), sweep.reflectivity.end());
  ASSERT_TRUE(restore_rings(sweep));
  EXPECT_EQ(sweep.rings, seen.size());
  EXPECT_NEAR(sweep.columns, columns, 0.01 * columns);
  for (size_t i = 0; i < sweep.size(); ++i) {
    const auto below = std::distance(seen.begin(), seen.find(sweep.reflectivity[i]));
    ASSERT_EQ(sweep.ring[i], below);
    if (i == 0 || sweep.ring[i] != sweep.ring[i - 1]) continue;
    ASSERT_GE(sweep.column[i], sweep.column[i - 1]);
  }
}

TEST(RestoreRings, PointsInAnyOrderFindTheirBeams) {
  expect_true_rings(even_beams(16, -15, 15), 1800, 0.03);
  expect_true_rings(even_beams(32, -30.67, 10.67), 2170, 0.03);
  expect_true_rings(kUnevenBeams, 1800, 0.03);
  expect_true_rings(even_beams(128, -11, 3), 1800, 0.03);
}

TEST(RestoreRings, BeamsFromDifferentHeightsOfASparseLidarAreStillTold) {
  Sweep sweep = shuffled_cloud(even_beams(16, -15, 15), 1800, 0.03, 2);
  for (size_t i = 0; i < sweep.size(); ++i) {
    sweep.z[i] += 0.004F * (sweep.reflectivity[i] - 8);
  }
  EXPECT_TRUE(restore_rings(sweep));
  EXPECT_GE(sweep.rings, 14);
}

TEST(RestoreRings, CloudsWithoutRingsAreRefused) {
  std::mt19937_64 random(3);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1; };
  for (const size_t points : {500U, 5'000U, 50'000U}) {
    Sweep sweep = shuffled_cloud(even_beams(64, -24, 4), 1800, 0, 4);
    ASSERT_GT(sweep.size(), points);
    sweep.resize(points);
    // Seen from elsewhere than where it was measured: tilted and raised.
    for (size_t i = 0; i < points; ++i) {
      const double z = static_cast<double>(sweep.z[i]) + 1.2 + 0.06 * uniform();
      sweep.z[i] = static_cast<float>(z + 0.05 * static_cast<double>(sweep.x[i]));
      sweep.range[i] = std::hypot(sweep.x[i], sweep.y[i], sweep.z[i]);
    }
    EXPECT_FALSE(restore_rings(sweep)) << points;
    EXPECT_EQ(sweep.rings, 0);
  }
}

TEST(RestoreRings, RealVlp16WithoutItsChannelsAsWithThem) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/vlp16-dual-return.reference.pcd");
  const auto bytes = text::read_text(path, 1 << 24);
  ASSERT_TRUE(bytes);
  Sweep with;
  ASSERT_TRUE(parse_pcd_sweep(*bytes, with));
  EXPECT_GE(with.rings, 15);
  std::string plain = *bytes;
  const std::string field = "channel";
  plain.replace(plain.find(field), field.size(), "another");
  Sweep without;
  ASSERT_TRUE(parse_pcd_sweep(plain, without));
  EXPECT_EQ(without.rings, with.rings);
  ASSERT_EQ(with.size(), without.size());
  std::multiset<std::pair<float, int>> a, b;
  for (size_t i = 0; i < with.size(); ++i) {
    a.insert({with.x[i], with.ring[i]});
    b.insert({without.x[i], without.ring[i]});
  }
  EXPECT_EQ(a, b);
}

TEST(RestoreRings, RealHdl64eInRandomOrderIsRefused) {
  INFUSE_REAL_DATA_OR_SKIP(path, "calibration/kitti/velodyne");
  Sweep sweep;
  ASSERT_TRUE(read_sweep_file(std::filesystem::directory_iterator(path)->path(), sweep));
  EXPECT_FALSE(restore_rings(sweep));
}

}  // namespace
}  // namespace infuse::recording
