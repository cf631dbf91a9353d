#include "fusion/mapping/closure_groups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace infuse::mapping {
namespace {

using Groups = std::vector<std::vector<size_t>>;

bool near(size_t a, size_t b) { return std::max(a, b) - std::min(a, b) <= 3; }

/// Joins whatever two groups have neighbours, until none have.
Groups joined(const PoseGraph<2>& graph, Groups groups) {
  const auto neighbours = [&](size_t e, size_t f) {
    const auto& a = graph.edges[e];
    const auto& b = graph.edges[f];
    return near(std::min(a.from, a.to), std::min(b.from, b.to)) &&
           near(std::max(a.from, a.to), std::max(b.from, b.to));
  };
  for (size_t i = 0; i < groups.size(); ++i) {
    for (size_t j = i + 1; j < groups.size(); ++j) {
      const bool together = std::any_of(groups[i].begin(), groups[i].end(), [&](size_t e) {
        return std::any_of(groups[j].begin(), groups[j].end(),
                           [&](size_t f) { return neighbours(e, f); });
      });
      if (!together) continue;
      groups[i].insert(groups[i].end(), groups[j].begin(), groups[j].end());
      groups.erase(groups.begin() + static_cast<ptrdiff_t>(j));
      return joined(graph, std::move(groups));
    }
  }
  return groups;
}

Groups sorted(Groups groups) {
  for (auto& group : groups) std::sort(group.begin(), group.end());
  std::sort(groups.begin(), groups.end());
  return groups;
}

TEST(ClosureGroups, AreThoseOfTheBruteForce) {
  std::mt19937 random(1);
  std::uniform_int_distribution<size_t> any(0, 59);
  for (int trial = 0; trial < 20; ++trial) {
    PoseGraph<2> graph;
    graph.poses.assign(60, Pose<2>::Identity());
    std::vector<char> accepted;
    Groups alone;
    for (size_t e = 0; e < 80; ++e) {
      PoseEdge<2> edge{any(random), any(random)};
      edge.closure = e % 5 != 0;
      accepted.push_back(e % 7 != 0);
      if (edge.closure && accepted[e] != 0) alone.push_back({e});
      graph.edges.push_back(edge);
    }
    const Groups groups = closure_groups<2>(graph, accepted);
    EXPECT_GT(groups.size(), 5U);
    EXPECT_LT(groups.size(), alone.size());
    EXPECT_EQ(sorted(groups), sorted(joined(graph, alone)));
  }
}

TEST(ClosureGroups, OfAGraphWithoutClosuresAreNone) {
  PoseGraph<2> graph;
  graph.poses.assign(2, Pose<2>::Identity());
  graph.edges = {{0, 1}};
  EXPECT_TRUE(closure_groups<2>(graph, {1}).empty());
}

}  // namespace
}  // namespace infuse::mapping
