#include "fusion/registration/rigid_consensus.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::registration {
namespace {

/// Correspondences of which the first `right` are right but for noise, the others drawn at random.
struct Drawn {
  Correspondences points;
  Eigen::Isometry3d T_target_source;
};

Drawn draw(uint64_t seed, size_t right, size_t wrong, double noise) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-30, 30);
  std::normal_distribution<double> error(0, noise);
  const auto point = [&] {
    return Eigen::Vector3d(place(random), place(random), 0.1 * place(random));
  };
  Drawn out;
  geometry::Vector6 xi;
  xi << 0.1, -0.2, 3, 5, -8, 1;
  out.T_target_source = geometry::exp(xi);
  for (size_t i = 0; i < right + wrong; ++i) {
    const Eigen::Vector3d p = point();
    const Eigen::Vector3d e(error(random), error(random), error(random));
    out.points.source.push_back(p);
    out.points.target.emplace_back(i < right ? Eigen::Vector3d(out.T_target_source * p + e)
                                             : point());
  }
  return out;
}

std::vector<uint32_t> all_of(size_t count) {
  std::vector<uint32_t> members(count);
  std::iota(members.begin(), members.end(), 0U);
  return members;
}

double error_of(const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth) {
  return geometry::log(T * truth.inverse()).norm();
}

TEST(FitRigid, IsExactWithoutNoiseAndALeastSquaresFitWithNoise) {
  const Drawn exact = draw(1, 3, 0, 0);
  EXPECT_LT(error_of(fit_rigid(exact.points, all_of(3)), exact.T_target_source), 1e-9);
  const Drawn noisy = draw(2, 50, 0, 0.3);
  const Eigen::Isometry3d T = fit_rigid(noisy.points, all_of(50));
  const auto cost = [&](const Eigen::Isometry3d& pose) {
    double sum = 0;
    for (size_t i = 0; i < 50; ++i) {
      sum += (pose * noisy.points.source[i] - noisy.points.target[i]).squaredNorm();
    }
    return sum;
  };
  for (int axis = 0; axis < 6; ++axis) {
    for (const double step : {-1e-3, 1e-3}) {
      geometry::Vector6 xi = geometry::Vector6::Zero();
      xi(axis) = step;
      EXPECT_GT(cost(geometry::exp(xi) * T), cost(T)) << axis;
    }
  }
}

TEST(FitRigid, IsAProperRotationForPointsOfAPlane) {
  Drawn drawn = draw(3, 20, 0, 0);
  for (size_t i = 0; i < 20; ++i) {
    drawn.points.source[i].z() = 0;
    drawn.points.target[i] = drawn.T_target_source * drawn.points.source[i];
  }
  const Eigen::Isometry3d T = fit_rigid(drawn.points, all_of(20));
  EXPECT_NEAR(T.linear().determinant(), 1, 1e-12);
  EXPECT_LT(error_of(T, drawn.T_target_source), 1e-9);
}

TEST(RigidConsensus, FindsThePoseAmongManyWrongCorrespondences) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const Drawn drawn = draw(seed, 40, 760, 0.1);
    RigidConsensusOptions options;
    options.seed = seed;
    const RigidConsensus found = find_rigid_consensus(drawn.points, options);
    ASSERT_TRUE(found.usable()) << found.reason;
    EXPECT_LT(error_of(found.hypotheses.front().T_target_source, drawn.T_target_source), 0.2);
    size_t right = 0;
    for (const uint32_t i : found.hypotheses.front().inliers) right += i < 40 ? 1 : 0;
    EXPECT_GE(right, 38U);
    EXPECT_GE(found.probability, 0.999);
  }
}

TEST(RigidConsensus, TheStatedProbabilityHolds) {
  // Of runs that may miss in one of three, two thirds must hit; the triple need not be perfect, so
  // somewhat fewer or more do.
  int hits = 0;
  constexpr int kRuns = 300;
  for (uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Drawn drawn = draw(seed, 20, 180, 0);
    RigidConsensusOptions options;
    options.seed = seed;
    options.probability = 2.0 / 3;
    options.min_share = 0.1;
    options.min_inliers = 15;
    const RigidConsensus found = find_rigid_consensus(drawn.points, options);
    hits += found.usable() ? 1 : 0;
  }
  // Samples with a short side or on a line are drawn, and count, but give no pose.
  EXPECT_GT(hits, kRuns * 0.55);
  EXPECT_LT(hits, kRuns * 0.75);
}

TEST(RigidConsensus, KeepsASecondPoseWhereTwoAgree) {
  Drawn a = draw(4, 60, 100, 0.05);
  const Drawn b = draw(5, 40, 0, 0.05);
  const Eigen::Isometry3d other = Eigen::Translation3d(12, 0, 0) * a.T_target_source;
  for (size_t i = 0; i < 40; ++i) {
    a.points.source.push_back(b.points.source[i]);
    a.points.target.emplace_back(other * b.points.source[i]);
  }
  RigidConsensusOptions options;
  options.hypotheses = 3;
  options.min_share = 0.1;
  const RigidConsensus found = find_rigid_consensus(a.points, options);
  ASSERT_GE(found.hypotheses.size(), 2U);
  EXPECT_LT(error_of(found.hypotheses[0].T_target_source, a.T_target_source), 0.05);
  EXPECT_LT(error_of(found.hypotheses[1].T_target_source, other), 0.05);
}

TEST(RigidConsensus, StatesWhyThereIsNone) {
  EXPECT_FALSE(find_rigid_consensus({}, {}).usable());
  const Drawn few = draw(6, 5, 0, 0);
  EXPECT_STREQ(find_rigid_consensus(few.points, {}).reason, "there are too few correspondences");
  const Drawn wrong = draw(7, 0, 300, 0);
  EXPECT_STREQ(find_rigid_consensus(wrong.points, {.min_share = 0.05}).reason,
               "no pose agrees with enough of the correspondences");
  // One place only: no triangle.
  Correspondences same;
  same.source.assign(50, {1, 2, 3});
  same.target.assign(50, {1, 2, 3});
  EXPECT_FALSE(find_rigid_consensus(same, {.min_share = 0.1}).usable());
}

TEST(RigidConsensus, TheSameSeedGivesTheSamePose) {
  const Drawn drawn = draw(8, 30, 200, 0.1);
  const RigidConsensus a = find_rigid_consensus(drawn.points, {});
  const RigidConsensus b = find_rigid_consensus(drawn.points, {});
  ASSERT_TRUE(a.usable());
  EXPECT_EQ(a.hypotheses[0].T_target_source.matrix(), b.hypotheses[0].T_target_source.matrix());
}

TEST(RigidConsensus, StatesWhatIsWrongWithTheOptions) {
  EXPECT_FALSE(RigidConsensusOptions().invalid());
  EXPECT_TRUE(RigidConsensusOptions{.inlier_distance = 0}.invalid());
  EXPECT_TRUE(RigidConsensusOptions{.min_inliers = 2}.invalid());
  EXPECT_TRUE(RigidConsensusOptions{.probability = 1}.invalid());
  EXPECT_TRUE(RigidConsensusOptions{.min_share = 0}.invalid());
  EXPECT_TRUE(RigidConsensusOptions{.hypotheses = 0}.invalid());
}

}  // namespace
}  // namespace infuse::registration
