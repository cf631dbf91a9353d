#include "fusion/features/discontinuity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace infuse::features {
namespace {

using testing::ElementsAre;
using testing::FloatNear;

std::vector<float> discontinuity(const Sweep& sweep, const DiscontinuityOptions& options) {
  return Discontinuity(options).compute(make_sweep_view(sweep));
}

/// Returns of the given rings at a spacing of 0.01 rad of azimuth; a range of 0 is no return.
Sweep make_sweep(const std::vector<std::vector<float>>& ranges, bool column_by_column = false) {
  Sweep sweep;
  const auto add = [&](size_t ring, size_t column) {
    const float range = ranges[ring][column];
    if (range == 0) return;
    const size_t i = sweep.size();
    sweep.resize(i + 1);
    const auto azimuth = -0.01F * static_cast<float>(column);
    sweep.x[i] = range * std::cos(azimuth);
    sweep.y[i] = range * std::sin(azimuth);
    sweep.z[i] = 0;
    sweep.range[i] = range;
    sweep.ring[i] = static_cast<uint16_t>(ring);
    sweep.column[i] = static_cast<uint16_t>(column);
  };
  if (column_by_column) {
    for (size_t column = 0; column < ranges[0].size(); ++column) {
      for (size_t ring = 0; ring < ranges.size(); ++ring) add(ring, column);
    }
  } else {
    for (size_t ring = 0; ring < ranges.size(); ++ring) {
      for (size_t column = 0; column < ranges[ring].size(); ++column) add(ring, column);
    }
  }
  return sweep;
}

TEST(Discontinuity, MarksTheNearSideOfAStep) {
  const auto edge = discontinuity(make_sweep({{5, 5, 9, 9}}), {.max_edge_azimuth = 0});
  EXPECT_THAT(edge, ElementsAre(0, 2, 0, 0));
}

TEST(Discontinuity, ALonePostIsMarkedFromBothSides) {
  const auto edge =
      discontinuity(make_sweep({{9, 5, 14, 14}}), {.gamma = 1, .max_edge_azimuth = 0});
  EXPECT_THAT(edge, ElementsAre(0, 9, 0, 0));
}

TEST(Discontinuity, RingsDoNotMix) {
  const Sweep sweep = make_sweep({{5, 5, 5}, {9, 9, 9}}, true);
  EXPECT_THAT(discontinuity(sweep, {.max_edge_azimuth = 0}), ElementsAre(0, 0, 0, 0, 0, 0));
}

TEST(Discontinuity, TheOrderOfFiringDoesNotMatter) {
  const std::vector<std::vector<float>> ranges{{5, 6, 9, 3}, {9, 8, 7, 7}};
  const auto by_ring = discontinuity(make_sweep(ranges), {.gamma = 1, .max_edge_azimuth = 0});
  const auto by_column =
      discontinuity(make_sweep(ranges, true), {.gamma = 1, .max_edge_azimuth = 0});
  EXPECT_THAT(by_ring, ElementsAre(1, 3, 0, 6, 0, 1, 1, 0));
  EXPECT_THAT(by_column, ElementsAre(1, 0, 3, 1, 0, 1, 6, 0));
}

TEST(Discontinuity, AFarNeighbourCountsAsTheNoReturnStep) {
  const Sweep sweep = make_sweep({{5, 0, 0, 0, 9}});
  EXPECT_THAT(discontinuity(sweep, {.gamma = 1, .max_edge_azimuth = 0}), ElementsAre(0, 0));
  EXPECT_THAT(discontinuity(sweep, {.gamma = 1, .no_return_step = 3, .max_edge_azimuth = 0}),
              ElementsAre(3, 3));
  EXPECT_THAT(discontinuity(sweep, {.gamma = 1, .max_gap = 0.05, .max_edge_azimuth = 0}),
              ElementsAre(FloatNear(4, 1e-6F), 0));
}

TEST(Discontinuity, ReturnsOfOneFiringAreNotNeighbours) {
  Sweep sweep = make_sweep({{5, 5, 5}});
  const size_t i = sweep.size();
  sweep.resize(i + 1);
  for (auto* channel : {&sweep.x, &sweep.y, &sweep.z, &sweep.range})
    (*channel)[i] = 2 * (*channel)[i - 1];
  sweep.ring[i] = 0;
  sweep.column[i] = sweep.column[i - 1];
  const auto edge = discontinuity(sweep, {.gamma = 1, .max_edge_azimuth = 0});
  EXPECT_FLOAT_EQ(edge[2], 0);  // 10 m in its own firing, 5 m in the one before
  EXPECT_FLOAT_EQ(edge[3], 0);
}

TEST(Discontinuity, OnlyReturnsNearAnEdgeAreCompared) {
  const Sweep sweep = make_sweep({{5, 5, 5, 5, 9, 9, 9, 9}, {7, 7, 7, 7, 7, 7, 7, 7.3F}});
  const auto edge =
      discontinuity(sweep, {.gamma = 1, .max_edge_azimuth = 0.021, .min_edge_step = 1});
  for (const size_t i : {1U, 2U, 3U, 4U, 5U}) EXPECT_EQ(edge[i], i == 3 ? 4 : 0) << i;
  // Farther than two columns from the edge, and on a ring whose only step is too small for one.
  for (const size_t i : {0U, 6U, 7U, 8U, 14U, 15U}) EXPECT_TRUE(std::isnan(edge[i])) << i;
}

TEST(Discontinuity, NeighboursLieWithinTheColumnGap) {
  const Sweep sweep = make_sweep({{5, 0, 9}});
  const DiscontinuityOptions options{.gamma = 1, .max_gap = 0.05, .max_edge_azimuth = 0};
  EXPECT_THAT(discontinuity(sweep, options), ElementsAre(FloatNear(4, 1e-6F), 0));
  DiscontinuityOptions adjacent = options;
  adjacent.max_column_gap = 1;
  EXPECT_THAT(discontinuity(sweep, adjacent), ElementsAre(0, 0));
}

TEST(Discontinuity, LargeStepsCountAsTheMaximum) {
  const Sweep sweep = make_sweep({{5, 60, 5}});
  EXPECT_THAT(discontinuity(sweep, {.max_step = 25, .max_edge_azimuth = 0}), ElementsAre(5, 0, 5));
}

TEST(Discontinuity, ASecondSweepDoesNotSeeTheFirst) {
  const Sweep first = make_sweep({{5, 9, 5, 9}, {7, 3, 7, 3}}), second = make_sweep({{4, 4, 4}});
  Discontinuity both({.max_edge_azimuth = 0});
  both.compute(make_sweep_view(first));
  EXPECT_THAT(both.compute(make_sweep_view(second)), ElementsAre(0, 0, 0));
}

TEST(Discontinuity, EmptySweep) { EXPECT_TRUE(discontinuity(Sweep{}, {}).empty()); }

TEST(RelativeDiscontinuity, IsTheRankAmongThoseOfTheRing) {
  std::mt19937_64 random(4);
  std::vector<uint16_t> ring;
  std::vector<float> edge;
  for (int i = 0; i < 300; ++i) {
    ring.push_back(static_cast<uint16_t>(random() % 4));
    const auto step = static_cast<float>(random() % 7) * static_cast<float>(1 + ring.back());
    edge.push_back(random() % 3 == 0 ? kNotCompared : step);
  }
  const std::vector<float> relative = relative_discontinuity(ring, edge);
  for (size_t i = 0; i < edge.size(); ++i) {
    if (std::isnan(edge[i])) {
      EXPECT_TRUE(std::isnan(relative[i]));
      continue;
    }
    int below = 0, equal = 0, all = 0;
    for (size_t j = 0; j < edge.size(); ++j) {
      if (ring[j] != ring[i] || std::isnan(edge[j])) continue;
      ++all;
      below += edge[j] < edge[i];
      equal += edge[j] == edge[i];
    }
    EXPECT_NEAR(relative[i], (below + 0.5 * (equal - 1)) / all, 1e-6);
  }
  EXPECT_TRUE(relative_discontinuity({}, {}).empty());
}

TEST(DiscontinuityOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(DiscontinuityOptions{}.invalid());
  EXPECT_TRUE((DiscontinuityOptions{.gamma = 0}.invalid()));
  EXPECT_TRUE((DiscontinuityOptions{.max_gap = 0}.invalid()));
  EXPECT_TRUE((DiscontinuityOptions{.max_column_gap = -1}.invalid()));
  EXPECT_TRUE((DiscontinuityOptions{.max_step = 0}.invalid()));
  EXPECT_TRUE((DiscontinuityOptions{.no_return_step = -1}.invalid()));
  EXPECT_TRUE((DiscontinuityOptions{.max_edge_azimuth = -1}.invalid()));
  EXPECT_TRUE((DiscontinuityOptions{.min_edge_step = 0}.invalid()));
}

}  // namespace
}  // namespace infuse::features
