#include "fusion/mapping/pose_graph.hpp"

#include <gtest/gtest.h>

#include "fusion/mapping/edge_cost.hpp"
#include "tests/fusion/mapping/random_graph.hpp"

namespace infuse::mapping {
namespace {

TEST(PoseGraph, FindsThePoseThatNoEdgesReach) {
  PoseGraph<2> graph;
  graph.poses.assign(5, Pose<2>::Identity());
  graph.edges = {{0, 1}, {2, 1}, {4, 3}};
  EXPECT_EQ(first_unconnected(graph), 3U);
  graph.edges.push_back({0, 4});
  EXPECT_EQ(first_unconnected(graph), 5U);
}

TEST(PoseGraph, ComposesOdometryBeforeClosures) {
  std::mt19937 random(1);
  const auto truth = random_walk<3>(20, random);
  PoseGraph<3> graph = random_graph<3>(truth, 30, 0, random);
  for (auto& edge : graph.edges) {  // a false closure changes nothing
    if (edge.closure) edge.T_from_to.translation().x() += 100;
  }
  graph.edges[7] = {8, 7, truth[8].inverse() * truth[7]};
  compose_odometry(graph);
  for (size_t i = 0; i < 20; ++i) EXPECT_TRUE(graph.poses[i].isApprox(truth[i], 1e-9)) << i;
}

TEST(PoseGraph, InformationOfAnEdgeIsThatOfItsCovariance) {
  std::mt19937 random(2);
  const Pose<3> T = random_walk<3>(2, random)[1];
  const PoseMatrix<3> root =
      PoseMatrix<3>::NullaryExpr([&] { return random_vector<3>(random, 1)[0]; });
  const PoseMatrix<3> covariance = root * root.transpose() + PoseMatrix<3>::Identity();
  const PoseEdge<3> edge{0, 1, T, edge_information(T, covariance)};
  for (int i = 0; i < 10; ++i) {
    const geometry::Vector6 xi = random_vector<3>(random, 1e-5);  // (rotation, translation)
    const double expected = xi.dot(covariance.inverse() * xi);
    const double cost =
        edge_cost<3>(edge, Pose<3>::Identity(), geometry::exp(xi) * T, Cost::kInformation);
    EXPECT_NEAR(cost, expected, 1e-3 * expected);
  }
}

}  // namespace
}  // namespace infuse::mapping
