#include "fusion/mapping/position_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>

namespace infuse::mapping {
namespace {

// Every position within the radius is found once, and none that is a cell farther away than that.
TEST(PositionGrid, FindsWhatIsNear) {
  constexpr double kCell = 5;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> coordinate(-60, 60);
  std::vector<Eigen::Vector3d> positions;
  PositionGrid grid(kCell);
  for (size_t i = 0; i < 400; ++i) {
    positions.emplace_back(coordinate(random), coordinate(random), coordinate(random));
    grid.add(i, positions.back());
  }
  for (const double radius : {0.5, 5.0, 17.0}) {
    for (size_t i = 0; i < positions.size(); ++i) {
      std::multiset<size_t> found;
      grid.for_each_near(positions[i], radius, [&](size_t other) { found.insert(other); });
      for (size_t other = 0; other < positions.size(); ++other) {
        const Eigen::Vector2d apart = (positions[other] - positions[i]).head<2>();
        const size_t times = found.count(other);
        EXPECT_LE(times, apart.cwiseAbs().maxCoeff() > radius + kCell ? 0U : 1U);
        EXPECT_GE(times, apart.norm() <= radius ? 1U : 0U);
      }
    }
  }
}

// Positions of a damaged or hostile file.
TEST(PositionGrid, WhatIsFartherThanAnyDriveIsAtTheEdge) {
  PositionGrid grid(3);
  const std::vector<double> far{-1e300, -1e12, 1e12, 1e300,
                                std::numeric_limits<double>::quiet_NaN()};
  for (size_t i = 0; i < far.size(); ++i) grid.add(i, {far[i], far[far.size() - 1 - i], 0});
  grid.add(far.size(), {1, 1, 0});
  for (size_t i = 0; i < far.size(); ++i) {
    std::set<size_t> found;
    grid.for_each_near({far[i], far[far.size() - 1 - i], 0}, 6,
                       [&](size_t other) { found.insert(other); });
    EXPECT_TRUE(found.contains(i));
    EXPECT_FALSE(found.contains(far.size()));
  }
}

}  // namespace
}  // namespace infuse::mapping
