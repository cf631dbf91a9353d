#include "fusion/mapping/edge_cost.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/mapping/random_graph.hpp"

namespace infuse::mapping {
namespace {

template <class Dimension>
class EdgeCost : public testing::Test {};

template <int D>
struct Dimensions {
  static constexpr int kValue = D;
};
using BothDimensions = testing::Types<Dimensions<2>, Dimensions<3>>;
TYPED_TEST_SUITE(EdgeCost, BothDimensions);

TYPED_TEST(EdgeCost, HasTheDerivativesOfFiniteDifferences) {
  constexpr int kD = TypeParam::kValue;
  std::mt19937 random(3);
  for (const Cost cost : {Cost::kInformation, Cost::kChordal}) {
    const auto walk = random_walk<kD>(2, random);
    const Pose<kD> from = moved(walk[1], random_vector<kD>(random, 1));
    PoseEdge<kD> edge{0, 1, walk[1]};
    const PoseMatrix<kD> root =
        PoseMatrix<kD>::NullaryExpr([&] { return random_vector<kD>(random, 1)[0]; });
    edge.information = root * root.transpose();
    const Pose<kD> to = moved(Pose<kD>(from * edge.T_from_to), random_vector<kD>(random, 0.3));
    const EdgeSystem<kD> system = linearize_edge<kD>(edge, from, to, cost);
    EXPECT_NEAR(system.cost, edge_cost<kD>(edge, from, to, cost), 1e-12 * system.cost);
    constexpr double kDelta = 1e-6;
    for (int k = 0; k < kPoseFreedom<kD>; ++k) {
      const Freedom<kD> step = kDelta * Freedom<kD>::Unit(k);
      const double by_from = edge_cost<kD>(edge, perturb<kD>(from, step), to, cost) -
                             edge_cost<kD>(edge, perturb<kD>(from, -step), to, cost);
      const double by_to = edge_cost<kD>(edge, from, perturb<kD>(to, step), cost) -
                           edge_cost<kD>(edge, from, perturb<kD>(to, -step), cost);
      EXPECT_NEAR(system.g_from[k], by_from / (4 * kDelta), 1e-6) << k;
      EXPECT_NEAR(system.g_to[k], by_to / (4 * kDelta), 1e-6) << k;
    }
    // Without a residual Gauss–Newton's matrix is half the second derivative.
    const Pose<kD> exact = from * edge.T_from_to;
    const EdgeSystem<kD> at_zero = linearize_edge<kD>(edge, from, exact, cost);
    EXPECT_NEAR(at_zero.cost, 0, 1e-12);
    for (int i = 0; i < 5; ++i) {
      const Freedom<kD> a = random_vector<kD>(random, 1e-4), b = random_vector<kD>(random, 1e-4);
      const double expected = a.dot(at_zero.H_from_from * a) + b.dot(at_zero.H_to_to * b) +
                              2 * b.dot(at_zero.H_to_from * a);
      EXPECT_NEAR(edge_cost<kD>(edge, perturb<kD>(from, a), perturb<kD>(exact, b), cost), expected,
                  2e-3 * expected);
    }
  }
}

TEST(EdgeCostValue, IsThatOfG2oInTheFile) {
  // e = (translation, angle): x is 1 too far, the angle 0.5.
  PoseEdge<2> edge{0, 1, Pose<2>(Eigen::Translation2d(1, 2))};
  edge.information.diagonal() << 3, 5, 7;
  const Pose<2> to = Eigen::Translation2d(2, 2) * Eigen::Rotation2Dd(0.5);
  EXPECT_NEAR(edge_cost<2>(edge, Pose<2>::Identity(), to, Cost::kInformation), 3 + 7 * 0.25, 1e-12);
}

TEST(ChordalWeights, AreHarmonicMeans) {
  PoseMatrix<2> planar = PoseMatrix<2>::Zero();
  planar.diagonal() << 1, 4, 9;
  EXPECT_NEAR(chordal_weights<2>(planar).rotation, 9, 1e-12);
  EXPECT_NEAR(chordal_weights<2>(planar).translation, 2 / 1.25, 1e-12);
  PoseMatrix<3> spatial = PoseMatrix<3>::Zero();
  spatial.diagonal() << 1, 2, 4, 10, 20, 40;
  EXPECT_NEAR(chordal_weights<3>(spatial).rotation, 3 / (2 * 0.175), 1e-12);
  EXPECT_NEAR(chordal_weights<3>(spatial).translation, 3 / 1.75, 1e-12);
}

}  // namespace
}  // namespace infuse::mapping
