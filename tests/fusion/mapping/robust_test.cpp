#include "fusion/mapping/robust.hpp"

#include <gtest/gtest.h>

#include <iostream>

#include "tests/fusion/mapping/random_graph.hpp"

namespace infuse::mapping {
namespace {

constexpr size_t kLap = 100, kPoses = 3 * kLap;
constexpr double kSigma = 0.01;

/// Three laps of a course of 100 m, with closures between laps at every third pose.
PoseGraph<2> laps(std::mt19937& random, std::vector<Pose<2>>& truth) {
  truth = {Pose<2>::Identity()};
  const Freedom<2> step(1, 0, 2 * std::numbers::pi / kLap);
  while (truth.size() < kPoses) truth.push_back(moved(truth.back(), step));
  PoseGraph<2> graph = random_graph<2>(truth, 0, kSigma, random);
  for (size_t i = 0; i + kLap < kPoses; i += 3) {
    graph.edges.push_back(measured_edge<2>(truth, i, i + kLap, kSigma, random));
  }
  return graph;
}

/// Adds a group of closures that agree with each other and state that two distant stretches of the
/// course are one.
void add_false_group(PoseGraph<2>& graph, const std::vector<Pose<2>>& truth, size_t size,
                     std::mt19937& random) {
  std::uniform_int_distribution<size_t> any(0, kPoses - size - 1);
  size_t from = 0, to = 0;
  do {
    from = any(random), to = any(random);
  } while ((truth[from].translation() - truth[to].translation()).norm() < 10);
  for (size_t k = 0; k < size; ++k) {
    PoseEdge<2> edge = measured_edge<2>(truth, from + k, to + k, kSigma, random);
    edge.T_from_to =
        (truth[from].inverse() * truth[from + k]).inverse() * (truth[to].inverse() * truth[to + k]);
    edge.T_from_to = moved(edge.T_from_to, random_vector<2>(random, kSigma));
    edge.closure = true;
    graph.edges.push_back(edge);
  }
}

double rms_error(const std::vector<Pose<2>>& poses, const std::vector<Pose<2>>& truth) {
  double sum = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    sum += (poses[i].translation() - truth[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

TEST(OptimizeRobustly, RejectsFalseClosuresAloneAndInGroups) {
  for (const size_t group : {1, 7}) {
    std::mt19937 random(7);
    for (int seed = 0; seed < 5; ++seed) {
      std::vector<Pose<2>> truth;
      PoseGraph<2> graph = laps(random, truth);
      const size_t true_edges = graph.edges.size();
      for (int i = 0; i < 35; i += static_cast<int>(group)) {  // half of the number of true ones
        add_false_group(graph, truth, group, random);
      }
      const RobustResult result = optimize_robustly(graph);
      ASSERT_TRUE(result.usable()) << result.reason;
      size_t true_rejected = 0, false_accepted = 0;
      for (size_t e = 0; e < graph.edges.size(); ++e) {
        if (e < true_edges) true_rejected += result.accepted[e] == 0;
        if (e >= true_edges) false_accepted += result.accepted[e] != 0;
      }
      EXPECT_EQ(false_accepted, 0U);
      EXPECT_LE(true_rejected, 1U);
      EXPECT_EQ(result.rejected_closures, 35 + true_rejected);
      EXPECT_LT(rms_error(graph.poses, truth), 1);  // of 32 m; all closures would bend it by more
    }
  }
}

TEST(OptimizeRobustly, FindsWhatStatesFarTooWideCovariances) {
  std::mt19937 random(8);
  std::vector<Pose<2>> truth;
  PoseGraph<2> graph = laps(random, truth);
  for (int i = 0; i < 5; ++i) add_false_group(graph, truth, 4, random);
  for (PoseEdge<2>& edge : graph.edges) edge.information /= 100;
  const RobustResult result = optimize_robustly(graph);
  ASSERT_TRUE(result.usable()) << result.reason;
  EXPECT_EQ(result.rejected_closures, 20U);
}

TEST(OptimizeRobustly, UncertainPathsDoNotMakeFalseClosuresPlausible) {
  // A helix whose turns see each other: odometry alone is lost after a few turns, the closures of
  // all turns together are not.
  constexpr size_t kTurn = 20, kTurns = 60, kFalse = 118;
  constexpr double kNoise = 0.02;  // m and rad, each step of a metre
  std::mt19937 random(10);
  std::vector<Pose<3>> truth = {Pose<3>::Identity()};
  Freedom<3> step;
  step << 1, 0, 0.05, 0, 0, 2 * std::numbers::pi / kTurn;
  while (truth.size() < kTurns * kTurn) truth.push_back(moved(truth.back(), step));
  PoseGraph<3> graph = random_graph<3>(truth, 0, kNoise, random);
  for (size_t i = 0; i + kTurn < truth.size(); ++i) {
    graph.edges.push_back(measured_edge<3>(truth, i, i + kTurn, kNoise, random));
  }
  const size_t true_edges = graph.edges.size();
  std::uniform_int_distribution<size_t> any(0, truth.size() - 1);
  while (graph.edges.size() < true_edges + kFalse) {  // a tenth of the number of true ones
    const size_t from = any(random), to = any(random);
    if ((truth[from].translation() - truth[to].translation()).norm() < 5) continue;
    PoseEdge<3> edge = measured_edge<3>(truth, 0, kTurn, kNoise, random);
    edge.from = from;
    edge.to = to;
    graph.edges.push_back(edge);
  }
  const RobustResult result = optimize_robustly(graph);
  ASSERT_TRUE(result.usable()) << result.reason;
  size_t false_accepted = 0;
  for (size_t e = true_edges; e < graph.edges.size(); ++e)
    false_accepted += result.accepted[e] != 0;
  EXPECT_EQ(false_accepted, 0U);
  EXPECT_LE(result.rejected_closures, kFalse + 23);  // at most 2 % of the true ones
}

// A serpentine through a small cube of noisy steps: the path to a false closure is so uncertain
// that it seems as likely as a true one, and its group bends the cube.
TEST(OptimizeRobustly, GroupsDoNotBendASmallGraph) {
  constexpr int kSide = 5;
  constexpr double kNoise = 0.2;  // m and rad, each step of a metre
  std::vector<Pose<3>> truth;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const int z = i / (kSide * kSide), row = i / kSide, column = i % kSide;
    const int y = z % 2 == 0 ? row % kSide : kSide - 1 - row % kSide;
    const int x = row % 2 == 0 ? column : kSide - 1 - column;
    truth.push_back(Pose<3>::Identity());
    truth.back().translation() = Eigen::Vector3d(x, y, z);
  }
  const auto distance = [&](size_t a, size_t b) {
    return (truth[a].translation() - truth[b].translation()).norm();
  };
  std::mt19937 random(11);
  size_t false_accepted = 0, true_rejected = 0, true_closures = 0;
  for (int seed = 0; seed < 20; ++seed) {
    PoseGraph<3> graph = random_graph<3>(truth, 0, kNoise, random);
    for (size_t i = 0; i < truth.size(); ++i) {
      for (size_t j = i + 2; j < truth.size(); ++j) {
        if (distance(i, j) > 1.01) continue;
        graph.edges.push_back(measured_edge<3>(truth, i, j, kNoise, random));
        ++true_closures;
      }
    }
    const size_t true_edges = graph.edges.size();
    for (int group = 0; group < 4; ++group) {
      constexpr size_t kSize = 7;
      std::uniform_int_distribution<size_t> any(0, truth.size() - kSize);
      size_t from = 0, to = 0;
      do {
        from = any(random), to = any(random);
      } while (distance(from, to) < 2);
      for (size_t k = 0; k < kSize; ++k) {
        PoseEdge<3> edge{from + k, to + k};
        edge.T_from_to = (truth[from].inverse() * truth[from + k]).inverse() *
                         (truth[to].inverse() * truth[to + k]);
        edge.information = graph.edges[0].information;
        edge.closure = true;
        graph.edges.push_back(edge);
      }
    }
    const RobustResult result = optimize_robustly(graph);
    EXPECT_TRUE(result.usable()) << result.reason;
    for (size_t e = 0; e < graph.edges.size(); ++e) {
      if (e < true_edges) true_rejected += result.accepted[e] == 0;
      if (e >= true_edges) false_accepted += result.accepted[e] != 0;
    }
  }
  std::cout << false_accepted << " of 560 false closures accepted, " << true_rejected << " of "
            << true_closures << " true ones rejected\n";
  EXPECT_LE(false_accepted, 30U);  // 67 with no group left out on trial
  EXPECT_LE(true_rejected, true_closures / 50);
}

TEST(OptimizeRobustly, StatesThatMostClosuresDisagree) {
  std::mt19937 random(9);
  std::vector<Pose<2>> truth;
  PoseGraph<2> graph = laps(random, truth);
  std::erase_if(graph.edges, [](const PoseEdge<2>& edge) { return edge.closure; });
  for (int i = 0; i < 5; ++i) add_false_group(graph, truth, 4, random);
  EXPECT_STREQ(optimize_robustly(graph).reason, "more closures are rejected than accepted");
}

TEST(OptimizeRobustly, StatesThatPosesAreNotDetermined) {
  PoseGraph<3> graph;
  EXPECT_STREQ(optimize_robustly(graph).reason, "the graph has fewer than two poses");
  graph.poses.assign(3, Pose<3>::Identity());
  graph.edges = {{0, 1}};
  EXPECT_STREQ(optimize_robustly(graph).reason, "the edges do not determine the poses");
}

}  // namespace
}  // namespace infuse::mapping
