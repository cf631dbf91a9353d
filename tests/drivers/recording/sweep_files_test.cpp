#include "drivers/recording/sweep_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

using ::testing::HasSubstr;

constexpr double kTwoPi = 2 * std::numbers::pi;

std::string to_bin(const std::vector<std::array<float, 4>>& points) {
  std::string bytes(points.size() * 16, '\0');
  std::memcpy(bytes.data(), points.data(), bytes.size());
  return bytes;
}

// A turn of `rings` rings from the top with `columns` steps, a fifth of the directions without a
// return.
struct SyntheticSweep {
  std::vector<std::array<float, 4>> points;
  std::vector<int> ring, column;
};
SyntheticSweep make_synthetic_sweep(int rings, int columns) {
  SyntheticSweep turn;
  for (int k = 0; k < rings; ++k) {
    const double elevation = (0.05 - 0.01 * k);
    for (int c = 0; c < columns; ++c) {
      if ((c * 7 + k * 3) % 5 == 0) continue;
      const double azimuth = (c + 0.5) * kTwoPi / columns;
      const double range = 5 + (c % 17);
      turn.points.push_back({static_cast<float>(range * std::cos(elevation) * std::cos(azimuth)),
                             static_cast<float>(range * std::cos(elevation) * std::sin(azimuth)),
                             static_cast<float>(range * std::sin(elevation)), 0.25f});
      turn.ring.push_back(rings - 1 - k);
      turn.column.push_back(c);
    }
  }
  return turn;
}

TEST(SweepFiles, InfersRingsAndColumnsOfASyntheticTurn) {
  for (const int rings : {2, 16, 64, 128}) {
    for (const int columns : {360, 2083}) {
      const SyntheticSweep turn = make_synthetic_sweep(rings, columns);
      const ScratchFolder folder;
      folder.write("a.bin", to_bin(turn.points));
      Sweep sweep;
      ASSERT_TRUE(read_sweep_file(folder / "a.bin", sweep));
      ASSERT_EQ(sweep.size(), turn.points.size());
      EXPECT_EQ(sweep.rings, rings);
      ASSERT_EQ(sweep.columns, static_cast<uint32_t>(columns));
      EXPECT_FALSE(sweep.has_times);
      for (size_t i = 0; i < sweep.size(); ++i) {
        ASSERT_EQ(sweep.ring[i], turn.ring[i]);
        ASSERT_EQ(sweep.column[i], turn.column[i]);
        ASSERT_NEAR(sweep.range[i], 5 + (turn.column[i] % 17), 1e-5);
        ASSERT_EQ(sweep.reflectivity[i], 0.25f);
      }
    }
  }
}

TEST(SweepFiles, InfersNoRingsFromAnotherOrderWithoutClustersOfElevations) {
  SyntheticSweep turn = make_synthetic_sweep(16, 360);
  std::reverse(turn.points.begin(), turn.points.end());             // clockwise, from below
  for (auto& [x, y, z, reflectance] : turn.points) z += 0.01f * x;  // of a tilted frame
  const ScratchFolder folder;
  folder.write("a.bin", to_bin(turn.points));
  folder.write("empty.bin", "");
  Sweep sweep;
  ASSERT_TRUE(read_sweep_file(folder / "a.bin", sweep));
  EXPECT_EQ(sweep.rings, 0);
  EXPECT_EQ(sweep.columns, 0u);
  EXPECT_EQ(sweep.ring[100], 0);
  ASSERT_TRUE(read_sweep_file(folder / "empty.bin", sweep));
  EXPECT_EQ(sweep.size(), 0u);
}

TEST(SweepFiles, SkipsPointsThatAreNotFiniteAndRejectsInvalidFiles) {
  const ScratchFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float huge = std::numeric_limits<float>::max();
  folder.write("a.bin",
               to_bin({{1, 2, 2, 0.5f}, {nan, 0, 0, 0}, {huge, huge, 0, 0}, {0, 3, 4, 1}}));
  Sweep sweep;
  ASSERT_TRUE(read_sweep_file(folder / "a.bin", sweep));
  ASSERT_EQ(sweep.size(), 2u);
  EXPECT_EQ(sweep.range[0], 3);
  EXPECT_EQ(sweep.range[1], 5);
  folder.write("b.bin", "0123456789");
  EXPECT_THAT(read_sweep_file(folder / "b.bin", sweep).error().message(),
              HasSubstr("multiple of 16"));
  EXPECT_FALSE(read_sweep_file(folder / "missing.bin", sweep));
  EXPECT_FALSE(read_sweep_file(folder.path(), sweep));
}

TEST(SweepFiles, WriteAndReadRoundTrip) {
  const ScratchFolder folder;
  const SyntheticSweep turn = make_synthetic_sweep(4, 100);
  folder.write("a.bin", to_bin(turn.points));
  Sweep sweep;
  ASSERT_TRUE(read_sweep_file(folder / "a.bin", sweep));
  ASSERT_TRUE(write_sweep_bin(folder / "b.bin", sweep));
  EXPECT_EQ(folder.read("b.bin"), folder.read("a.bin"));
}

TEST(SweepFiles, RealKittiSweepsHaveSixtyFourRings) {
  INFUSE_REAL_DATA_OR_SKIP(path, "calibration/kitti/velodyne");
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    SCOPED_TRACE(entry.path().string());
    Sweep sweep;
    ASSERT_TRUE(read_sweep_file(entry.path(), sweep));
    EXPECT_EQ(sweep.rings, 64);
    // 10 turns per second, one firing every 48 µs: 2083 per turn.
    EXPECT_NEAR(sweep.columns, 2083, 100);
    // The lowest beam points 24.8° down, the highest 2° up.
    std::array<std::pair<double, int>, 64> elevation{};
    for (size_t i = 0; i < sweep.size(); ++i) {
      auto& [sum, count] = elevation[sweep.ring[i]];
      sum += std::asin(sweep.z[i] / sweep.range[i]);
      ++count;
    }
    EXPECT_NEAR(elevation[0].first / elevation[0].second * 360 / kTwoPi, -24, 2);
    EXPECT_GT(elevation[63].first / elevation[63].second * 360 / kTwoPi, 0);
    // One return per direction, except where the corrections of two beams coincide.
    std::set<std::pair<int, int>> cells;
    for (size_t i = 0; i < sweep.size(); ++i) cells.insert({sweep.ring[i], sweep.column[i]});
    EXPECT_GT(static_cast<double>(cells.size()), 0.8 * static_cast<double>(sweep.size()));
  }
}

}  // namespace
}  // namespace infuse::recording
