#include "fusion/mapping/optimize.hpp"

#include <gtest/gtest.h>

#include "fusion/mapping/chordal_initialisation.hpp"
#include "tests/fusion/mapping/random_graph.hpp"

namespace infuse::mapping {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(ChordalInitialisation, IsExactWithoutNoise) {
  std::mt19937 random(4);
  const auto planar_truth = random_walk<2>(50, random);
  PoseGraph<2> planar = random_graph<2>(planar_truth, 20, 0, random);
  ASSERT_TRUE(initialise_chordal(planar));
  const auto spatial_truth = random_walk<3>(50, random);
  PoseGraph<3> spatial = random_graph<3>(spatial_truth, 20, 0, random);
  ASSERT_TRUE(initialise_chordal(spatial));
  for (size_t i = 0; i < 50; ++i) {
    EXPECT_TRUE(planar.poses[i].isApprox(planar_truth[i], 1e-9)) << i;
    EXPECT_TRUE(spatial.poses[i].isApprox(spatial_truth[i], 1e-9)) << i;
  }
}

TEST(ChordalInitialisation, StatesThatPosesAreNotDetermined) {
  PoseGraph<3> graph;
  graph.poses.assign(3, Pose<3>::Identity());
  graph.edges = {{0, 1}};
  EXPECT_FALSE(initialise_chordal(graph));
}

/// Poses of a ring of n odometry steps of length 1 whose closure is wrong by `angle`: the optimum
/// shares the error evenly (κ is large, so positions do not matter).
TEST(PoseGraphSolver, SharesTheErrorOfARingOfRotations) {
  constexpr size_t kPoses = 10;
  constexpr double kError = 0.2;
  PoseGraph<2> graph;
  graph.poses.assign(kPoses, Pose<2>::Identity());
  for (size_t i = 0; i < kPoses; ++i) {
    PoseEdge<2> edge{i, (i + 1) % kPoses};
    edge.T_from_to.linear() =
        Eigen::Rotation2Dd((2 * kPi + kError) / static_cast<double>(kPoses)).toRotationMatrix();
    graph.edges.push_back(edge);
  }
  for (const Cost cost : {Cost::kInformation, Cost::kChordal}) {
    PoseGraph<2> optimised = graph;
    compose_odometry(optimised);
    const OptimizeResult result = PoseGraphSolver<2>(optimised).optimize(optimised, {.cost = cost});
    ASSERT_TRUE(result.usable()) << result.reason;
    const double each = kError / static_cast<double>(kPoses);
    const double chord = 2 * std::sqrt(2.0) * std::sin(each / 2);
    EXPECT_NEAR(result.cost, kPoses * (cost == Cost::kChordal ? chord * chord : each * each), 1e-9);
    EXPECT_NEAR(result.cost, total_cost(optimised, cost), 1e-12);
  }
}

TEST(PoseGraphSolver, FindsTheTruthWithinItsCovariance) {
  std::mt19937 random(5);
  constexpr double kSigma = 0.02;
  double sum = 0;
  constexpr size_t kRuns = 40, kAsked = 25;
  double chi2 = 0;
  for (size_t run = 0; run < kRuns; ++run) {
    const auto truth = random_walk<3>(30, random);
    PoseGraph<3> graph = random_graph<3>(truth, 20, kSigma, random);
    ASSERT_TRUE(initialise_chordal(graph));
    PoseGraphSolver<3> solver(graph);
    const OptimizeResult result = solver.optimize(graph);
    ASSERT_TRUE(result.usable()) << result.reason;
    chi2 += result.cost;
    const auto covariances = solver.covariances(graph, {0, kAsked});
    ASSERT_EQ(covariances.size(), 2U);
    EXPECT_TRUE(covariances[0].isZero());
    const geometry::Vector6 error = geometry::log(truth[kAsked] * graph.poses[kAsked].inverse());
    sum += error.dot(covariances[1].inverse() * error);
  }
  // χ² of 6 degrees of freedom for the pose, of 20 × 6 for the graph: means within five sigma.
  EXPECT_NEAR(sum / kRuns, 6, 5 * std::sqrt(12.0 / kRuns));
  EXPECT_NEAR(chi2 / kRuns, 120, 5 * std::sqrt(240.0 / kRuns));
}

TEST(PoseGraphSolver, CovarianceOfOneEdgeIsWhatItStates) {
  std::mt19937 random(6);
  const PoseMatrix<3> root =
      PoseMatrix<3>::NullaryExpr([&] { return random_vector<3>(random, 0.1)[0]; });
  const PoseMatrix<3> covariance = root * root.transpose() + 0.01 * PoseMatrix<3>::Identity();
  PoseGraph<3> graph;
  graph.poses = random_walk<3>(2, random);
  graph.edges = {{0, 1, graph.poses[1], edge_information(graph.poses[1], covariance)}};
  const auto covariances = PoseGraphSolver<3>(graph).covariances(graph, {1});
  ASSERT_EQ(covariances.size(), 1U);
  EXPECT_TRUE(covariances[0].isApprox(covariance, 1e-9));
}

TEST(PoseGraphSolver, CovarianceOfAPlanarChainIsPropagated) {
  // Turn by an uncertain angle at the origin, then go 10 m: y is uncertain by 10 m × sigma.
  PoseGraph<2> graph;
  graph.poses = {Pose<2>::Identity(), Pose<2>::Identity(), Pose<2>(Eigen::Translation2d(10, 0))};
  graph.edges = {{0, 1}, {1, 2, graph.poses[2]}};
  graph.edges[0].information.diagonal() << 1e8, 1e8, 1e4;
  graph.edges[1].information.diagonal() << 1e8, 1e8, 1e8;
  const auto covariances = PoseGraphSolver<2>(graph).covariances(graph, {2});
  ASSERT_EQ(covariances.size(), 1U);
  // The left perturbation is about the origin: the angle there, nothing at x and y.
  EXPECT_NEAR(covariances[0](0, 0), 1e-4, 1e-7);
  EXPECT_NEAR(covariances[0](2, 2), 1e-8 + 1e-8 + 1e-6, 1e-7);
}

TEST(PoseGraphSolver, StatesWhyPosesAreNotUsable) {
  PoseGraph<3> graph;
  EXPECT_FALSE(PoseGraphSolver<3>(graph).optimize(graph).usable());
  graph.poses.assign(3, Pose<3>::Identity());
  graph.edges = {{0, 1}};
  PoseGraphSolver<3> solver(graph);
  EXPECT_STREQ(solver.optimize(graph).reason, "the edges do not determine the poses");
  EXPECT_TRUE(solver.covariances(graph, {1}).empty());
}

TEST(OptimizeOptions, NameWhatIsInvalid) {
  EXPECT_FALSE(OptimizeOptions{}.invalid());
  EXPECT_TRUE((OptimizeOptions{.max_iterations = 0}.invalid()));
  EXPECT_TRUE((OptimizeOptions{.tolerance = 0}.invalid()));
}

}  // namespace
}  // namespace infuse::mapping
