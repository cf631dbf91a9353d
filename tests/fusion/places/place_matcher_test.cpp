#include "fusion/places/place_matcher.hpp"

#include <gtest/gtest.h>

#include "fusion/places/localiser.hpp"
#include "tests/fusion/places/invented_map.hpp"

namespace infuse::places {
namespace {

constexpr double kLength = 80;  // m

mapping::Submap seen_at(const InventedStreet& street, const Eigen::Isometry3d& T_map_vehicle) {
  return street.seen_from(T_map_vehicle * lidar_above(), 7);
}

TEST(PlaceMatcher, FindsThePlaceInEitherDirection) {
  PlaceMatcher matcher(make_map(street(), kLength), lidar_above());
  for (const double yaw : {0.0, 3.1}) {
    const Eigen::Isometry3d truth = on_street(41, 1, yaw);
    const auto found = matcher.search(seen_at(street(), truth));
    ASSERT_TRUE(found);
    ASSERT_FALSE(found->places.empty()) << yaw;
    const geometry::Vector6 error =
        geometry::log(found->places.front().T_map_vehicle.inverse() * truth);
    EXPECT_LT(error.tail<3>().norm(), 0.1);
    EXPECT_LT(error.head<3>().norm(), 0.01);
    EXPECT_LT(error.dot(found->places.front().covariance.ldlt().solve(error)), 30);
    EXPECT_GT(found->probabilities.best, 0.99);
  }
}

TEST(PlaceMatcher, RecognisesNothingOfAnotherStreet) {
  PlaceMatcher matcher(make_map(street(), kLength), lidar_above());
  for (const double along : {20.0, 41.0, 60.0}) {
    const auto found = matcher.search(seen_at(InventedStreet(6), on_street(along, 0, 0)));
    ASSERT_TRUE(found);
    EXPECT_LT(found->probabilities.best, LocaliserOptions().min_probability) << along;
  }
}

TEST(PlaceMatcher, ReturnsBothPlacesThatFit) {
  PlaceMatcher matcher(make_map_twice(street(), kLength), lidar_above());
  const auto found = matcher.search(seen_at(street(), on_street(41, 0, 0)));
  ASSERT_TRUE(found);
  ASSERT_GE(found->places.size(), 2U);
  EXPECT_NEAR(found->probabilities.best, 0.5, 0.1);
  EXPECT_NEAR(found->probabilities.runner_up, 0.5, 0.1);
}

TEST(PlaceMatcher, MatchesAtAKeyframeWhatWasSeenThere) {
  PlaceMatcher matcher(make_map(street(), kLength), lidar_above());
  const Eigen::Isometry3d truth = on_street(41, 1, 0);
  const Eigen::Isometry3d guess = on_street(42, 0.5, 0.05);
  const auto keyframe = matcher.nearest_keyframe(guess);
  ASSERT_TRUE(keyframe);
  const auto matched = matcher.match(*keyframe, seen_at(street(), truth), guess);
  ASSERT_TRUE(matched && matched->place);
  EXPECT_LT((matched->place->T_map_vehicle.translation() - truth.translation()).norm(), 0.1);
  EXPECT_GT(log_odds(matched->fit), 0);
  const auto nothing = matcher.match(*keyframe, mapping::Submap(), guess);
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(nothing->place);
  EXPECT_LT(log_odds(nothing->fit), 0);
  EXPECT_FALSE(matcher.nearest_keyframe(on_street(kLength + 13, 0, 0)));
}

}  // namespace
}  // namespace infuse::places
