#include "fusion/streetmap/global_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::streetmap {
namespace {

constexpr double kGain = 2, kEstimateScore = 0.9;

/// A drive on which the estimate is 9 m behind the truth and is corrected by up to `correction` (m
/// per axis) on each view. Poses within 4 m of the truth score 1, all others less than the
/// estimate.
class WrongDrive {
 public:
  explicit WrongDrive(double correction) : share_(-correction, correction) {}

  /// Views until the search finds a place, which is the truth; `limit` if it finds none.
  int views_until_found(GlobalSearch& search, int limit) {
    for (int i = 1; i <= limit; ++i) {
      truth_ = truth_.compose({1, 0, i % 20 < 10 ? 0.0 : 0.05});
      const PlanarPose estimate =
          truth_.compose({-9 + share_(random_), 1 + share_(random_), 0.02 * share_(random_)});
      const auto off = [&](const PlanarPose& pose) {
        return std::hypot(pose.x - truth_.x, pose.y - truth_.y);
      };
      const auto found =
          search.update(estimate, 0.1 * Eigen::Matrix2d::Identity(), kEstimateScore, 0.3, kGain,
                        [&](const PlanarPose& pose) { return off(pose) < 4 ? 1.0 : 0.5; });
      if (!found) continue;
      EXPECT_LT(off(*found), 4);
      return i;
    }
    return limit;
  }

 private:
  PlanarPose truth_{3, -2, 0.4};
  std::mt19937 random_{1};
  std::uniform_real_distribution<double> share_;
};

/// Views that the evidence of the truth, of 0.2 each, needs to reach the odds of another place.
int views_needed() {
  int views = 0;
  while (!PlaceCheckOptions().is_better(views * kGain * (1 - kEstimateScore))) ++views;
  return views;
}

// More than twice the views after which what fits no better is given up.
TEST(GlobalSearch, EvidenceIsKeptWhileTheEstimateIsCorrected) {
  ASSERT_GT(views_needed(), 20);
  for (const uint64_t seed : {1U, 2U, 3U}) {
    for (const double correction : {0.0, 0.5}) {
      GlobalSearch search({}, {}, seed);
      WrongDrive drive(correction);
      EXPECT_EQ(drive.views_until_found(search, 100), views_needed()) << seed << ' ' << correction;
      // Found once, it needs as much again.
      EXPECT_GE(drive.views_until_found(search, 100), views_needed());
    }
  }
}

TEST(GlobalSearch, AResetDropsTheEvidence) {
  GlobalSearch search({}, {}, 1);
  WrongDrive drive(0.5);
  const int almost = views_needed() - 1;
  EXPECT_EQ(drive.views_until_found(search, almost), almost);
  search.reset();
  EXPECT_GE(drive.views_until_found(search, 100), views_needed());
}

}  // namespace
}  // namespace infuse::streetmap
