#include "fusion/mapping/closure_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace infuse::mapping {
namespace {

constexpr double kRadius = 40, kStep = 2;  // m

/// True poses on a circle that is driven one and a half times.
std::vector<Eigen::Isometry3d> circle() {
  std::vector<Eigen::Isometry3d> poses;
  for (double way = 0; way < 3 * std::numbers::pi * kRadius; way += kStep) {
    const double angle = way / kRadius;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = kRadius * Eigen::Vector3d(std::sin(angle), 1 - std::cos(angle), 0);
    T.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    poses.push_back(T);
  }
  return poses;
}

/// Odometry along the poses whose heading drifts by `drift` rad/m, and states `stated` rad/√m.
std::vector<Keyframe> drifting(const std::vector<Eigen::Isometry3d>& truth, double drift,
                               double stated) {
  std::vector<Keyframe> keyframes;
  for (size_t k = 0; k < truth.size(); ++k) {
    Keyframe keyframe;
    keyframe.stamp = Stamp::from_ns(static_cast<int64_t>(k) * 200'000'000);
    keyframe.distance_driven = static_cast<double>(k) * kStep;
    if (k > 0) {
      const Eigen::AngleAxisd turn(drift * kStep, Eigen::Vector3d::UnitZ());
      keyframe.T_odom_vehicle =
          keyframes.back().T_odom_vehicle * (truth[k - 1].inverse() * truth[k]) * turn;
      geometry::Vector6 variance = geometry::Vector6::Constant(stated * stated * kStep);
      variance.tail<3>().setConstant(1e-4);
      keyframe.covariance = variance.asDiagonal();
    }
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

/// A registration that is right where the guess is, of places that see the same up to 12 m apart.
VerifyClosure perfect(const std::vector<Eigen::Isometry3d>& truth, double basin) {
  return [=](Closure& closure) -> Result<void> {
    const Eigen::Isometry3d T = truth[closure.from].inverse() * truth[closure.to];
    const bool found =
        !closure.guessed || (T.translation() - closure.T_from_to.translation()).norm() <= basin;
    closure.T_from_to = T;
    closure.covariance = geometry::Matrix6::Identity() * 1e-4;
    closure.reason = found && T.translation().norm() < 12 ? "" : "not found";
    return {};
  };
}

TEST(ClosureSearch, FindsTheSecondTurnDespiteDrift) {
  const auto truth = circle();
  const auto keyframes = drifting(truth, 2e-4, 2e-3);
  const size_t turn = static_cast<size_t>(2 * std::numbers::pi * kRadius / kStep);
  const double drifted =
      (keyframes[turn].T_odom_vehicle.translation() - truth[turn].translation()).norm();
  EXPECT_GT(drifted, 1.5) << "else nothing is shown";
  const auto closures = search_closures(keyframes, {}, {}, {}, {}, perfect(truth, 2));
  ASSERT_TRUE(closures);
  // Half a circle is driven twice, with a closure every 4 m.
  size_t accepted = 0;
  for (const Closure& closure : *closures) {
    const double distance =
        (truth[closure.from].translation() - truth[closure.to].translation()).norm();
    accepted += closure.accepted() ? 1 : 0;
    EXPECT_EQ(closure.accepted(), distance < 12) << closure.reason;
    EXPECT_GE(keyframes[closure.to].distance_driven - keyframes[closure.from].distance_driven, 40);
  }
  EXPECT_GE(accepted, 25U);
}

// What odometry has further apart than a closure may be is sought only where it is uncertain.
TEST(ClosureSearch, SeeksWithinTheStatedUncertaintyOnly) {
  const auto truth = circle();
  for (const double stated : {1e-7, 0.05}) {
    const auto keyframes = drifting(truth, 4e-3, stated);
    double furthest = 0;
    const auto measure = [&](Closure& closure) -> Result<void> {
      furthest = std::max(furthest, closure.T_from_to.translation().norm());
      closure.reason = "no";
      return {};
    };
    ASSERT_TRUE(search_closures(keyframes, {}, {}, {}, {}, measure));
    EXPECT_EQ(furthest > 6.5, stated > 1e-3) << furthest;
    EXPECT_GT(furthest, 0);
  }
}

TEST(ClosureSearch, RejectsWhatTheOdometryContradicts) {
  const auto truth = circle();
  const auto lie = [&](Closure& closure) -> Result<void> {
    closure.T_from_to.translation().x() += 11.9;  // beyond 6 m and 3 sigmas
    closure.reason.clear();
    return {};
  };
  const auto closures = search_closures(drifting(truth, 0, 1e-5), {}, {}, {}, {}, lie);
  ASSERT_TRUE(closures);
  ASSERT_FALSE(closures->empty());
  for (const Closure& closure : *closures) EXPECT_FALSE(closure.accepted());
}

// Poses from GNSS show the second turn where odometry has lost itself.
TEST(ClosureSearch, UsesKnownPosesWhereTheyAreMoreCertain) {
  const auto truth = circle();
  const auto keyframes = drifting(truth, 4e-3, 0.05);
  const auto alone = search_closures(keyframes, {}, {}, {}, {}, perfect(truth, 2));
  const auto known =
      search_closures(keyframes, {}, {}, KnownPoses{truth, 0.5}, {}, perfect(truth, 2));
  ASSERT_TRUE(alone && known);
  const auto accepted = [](const std::vector<Closure>& closures) {
    return std::count_if(closures.begin(), closures.end(),
                         [](const Closure& closure) { return closure.accepted(); });
  };
  EXPECT_GE(accepted(*known), 25);
  EXPECT_LT(accepted(*alone), accepted(*known));
}

// Where only the pose of a keyframe is left, others stand for it; what an earlier search found is
// not sought again, and corrects where the others are sought.
TEST(ClosureSearch, GoesOnFromAnEarlierMap) {
  const auto truth = circle();
  auto keyframes = drifting(truth, 2e-4, 2e-3);
  const auto first = search_closures(keyframes, {}, {}, {}, {}, perfect(truth, 2));
  ASSERT_TRUE(first);
  std::vector<Closure> earlier;
  for (const Closure& closure : *first) {
    if (closure.accepted()) earlier.push_back(closure);
  }
  ASSERT_GT(earlier.size(), 10U);
  earlier.erase(earlier.begin() + 2, earlier.begin() + 6);
  for (size_t k = 0; k < keyframes.size(); k += 2) keyframes[k].has_cloud = false;
  const auto second = search_closures(keyframes, {}, earlier, {}, {}, perfect(truth, 0.3));
  ASSERT_TRUE(second);
  size_t accepted = 0;
  for (const Closure& closure : *second) {
    EXPECT_EQ(closure.from % 2, 1U);
    EXPECT_EQ(closure.to % 2, 1U);
    accepted += closure.accepted() ? 1 : 0;
  }
  EXPECT_GE(accepted, 3U) << "the gap is closed, from guesses that are right to 0.3 m";
  EXPECT_LT(accepted, first->size() / 2);
}

TEST(ClosureSearch, PassesErrorsOn) {
  const auto truth = circle();
  const auto closures = search_closures(drifting(truth, 0, 1e-3), {}, {}, {}, {}, [](Closure&) {
    return Result<void>(fail("a cloud is damaged"));
  });
  EXPECT_FALSE(closures);
  EXPECT_TRUE(search_closures({}, {}, {}, {}, {}, perfect(truth, 2)));
}

}  // namespace
}  // namespace infuse::mapping
