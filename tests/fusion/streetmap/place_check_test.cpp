#include "fusion/streetmap/place_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap {
namespace {

/// Drives a check by 60 views in which `estimate` scores 0.9 and `truth` scores 1, each within a
/// metre or two; both move on by the same motions.
PlaceCheck drive_check(PlanarPose estimate, PlanarPose truth, uint64_t seed) {
  static const town::Town town = town::build(town::plan());
  PlaceCheck check({}, seed);
  check.start(estimate, town.map);
  for (int i = 0; i < 60 && check.running(); ++i) {
    const PlanarPose motion{1, 0, i % 20 < 10 ? 0.0 : 0.05};
    estimate = estimate.compose(motion);
    truth = truth.compose(motion);
    const auto peak = [](const PlanarPose& at, const PlanarPose& pose) {
      const PlanarPose d = at.motion_to(pose);
      return std::exp(-(d.x * d.x + d.y * d.y) / (2 * 1.2 * 1.2) - 50 * d.yaw * d.yaw);
    };
    const auto score = [&](const PlanarPose& pose) {
      return std::max(0.9 * peak(estimate, pose), peak(truth, pose));
    };
    check.update(estimate, 0.1 * Eigen::Matrix2d::Identity(), 2, score,
                 [](const PlanarPose&) { return 0.0; });
  }
  return check;
}

TEST(PlaceCheck, TheTruthFurtherAlongAndReversedIsNotRuledOut) {
  for (const uint64_t seed : {1U, 2U, 3U}) {
    for (const double along : {-33.0, -17.7, 0.0, 9.5, 25.0}) {
      const PlanarPose estimate{-20, -1, 0};
      const PlanarPose truth = estimate.compose({along, 0.3, std::numbers::pi});
      PlaceCheck check = drive_check(estimate, truth, seed);
      EXPECT_TRUE(check.running()) << along;
      EXPECT_GT(check.elsewhere(), 0.5) << along;
    }
  }
}

TEST(PlaceCheck, ATruthThatIsNowhereNearIsRuledOut) {
  const PlanarPose estimate{-20, -1, 0};
  const PlaceCheck check = drive_check(estimate, estimate.compose({1000, 0, 0}), 1);
  EXPECT_FALSE(check.running());
  EXPECT_LT(check.elsewhere(), 0.02);
}

// Of places that have e^-9 of the odds by the drive, two views that see no difference leave
// nothing; equal places remain. What the drive says is not added up over the views.
TEST(PlaceCheck, TheDriveCounts) {
  const town::Town town = town::build(town::plan());
  const PlanarPose estimate{-20, -1, 0};
  const auto update = [&](PlaceCheck& check, double by_drive) {
    check.update(
        estimate, 0.1 * Eigen::Matrix2d::Identity(), 2, [](const PlanarPose&) { return 0.5; },
        [&](const PlanarPose& place) {
          EXPECT_GT(std::hypot(place.x - estimate.x, place.y - estimate.y), 1);
          return by_drive;
        });
  };
  for (const double by_drive : {0.0, -9.0}) {
    PlaceCheck check({}, 1);
    check.start(estimate, town.map);
    update(check, by_drive);
    update(check, by_drive);
    EXPECT_EQ(check.running(), by_drive == 0);
  }
  PlaceCheck check({}, 1);
  check.start(estimate, town.map);
  for (int i = 0; i < 9; ++i) update(check, -1);
  EXPECT_TRUE(check.running());
  EXPECT_GT(check.elsewhere(), 0.5);
}

// Draws of a Gaussian are in its region in 99 of 100 cases; the reverse direction never is.
TEST(PlaceCheck, ARegionHolds99PercentOfItsPoses) {
  constexpr int kDraws = 4000;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Eigen::Matrix2d L;
  L << 2, 0, 0.7, 0.5;
  const PlanarPose estimate{4, -3, 1};
  int inside = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector2d d = L * Eigen::Vector2d(normal(random), normal(random));
    const PlanarPose pose{estimate.x + d.x(), estimate.y + d.y(), estimate.yaw};
    inside += is_in_region(pose, estimate, L * L.transpose());
    EXPECT_FALSE(is_in_region(pose.compose({0, 0, 3}), estimate, L * L.transpose()));
  }
  EXPECT_NEAR(inside, 0.99 * kDraws, 4 * std::sqrt(0.99 * 0.01 * kDraws));
}

}  // namespace
}  // namespace infuse::streetmap
