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

PlaceProbabilities probabilities_of(const std::vector<MatchedPlace>& found) {
  std::vector<PlaceFit> fits;
  for (const MatchedPlace& place : found) fits.push_back(place.fit);
  return place_probabilities(fits);
}

TEST(PlaceMatcher, FindsThePlaceInEitherDirection) {
  PlaceMatcher matcher(make_map(street(), kLength), lidar_above());
  for (const double yaw : {0.0, 3.1}) {
    const Eigen::Isometry3d truth = on_street(41, 1, yaw);
    const auto found = matcher.search(seen_at(street(), truth));
    ASSERT_TRUE(found);
    ASSERT_FALSE(found->empty()) << yaw;
    const geometry::Vector6 error = geometry::log(found->front().T_map_vehicle.inverse() * truth);
    EXPECT_LT(error.tail<3>().norm(), 0.1);
    EXPECT_LT(error.head<3>().norm(), 0.01);
    EXPECT_LT(error.dot(found->front().covariance.ldlt().solve(error)), 30);
    EXPECT_GT(probabilities_of(*found).best, 0.99);
  }
}

TEST(PlaceMatcher, RecognisesNothingOfAnotherStreet) {
  PlaceMatcher matcher(make_map(street(), kLength), lidar_above());
  for (const double along : {20.0, 41.0, 60.0}) {
    const auto found = matcher.search(seen_at(InventedStreet(6), on_street(along, 0, 0)));
    ASSERT_TRUE(found);
    EXPECT_LT(probabilities_of(*found).best, LocaliserOptions().min_probability) << along;
  }
}

TEST(PlaceMatcher, ReturnsBothPlacesThatFit) {
  PlaceMatcher matcher(make_map_twice(street(), kLength), lidar_above());
  const auto found = matcher.search(seen_at(street(), on_street(41, 0, 0)));
  ASSERT_TRUE(found);
  ASSERT_GE(found->size(), 2U);
  const PlaceProbabilities probabilities = probabilities_of(*found);
  EXPECT_NEAR(probabilities.best, 0.5, 0.1);
  EXPECT_NEAR(probabilities.runner_up, 0.5, 0.1);
}

TEST(PlaceMatcher, MatchesNearAPoseAndNotOffTheMap) {
  PlaceMatcher matcher(make_map(street(), kLength), lidar_above());
  const Eigen::Isometry3d truth = on_street(41, 1, 0);
  const auto matched = matcher.match_near(seen_at(street(), truth), on_street(42, 0.5, 0.05));
  ASSERT_TRUE(matched && *matched);
  EXPECT_LT(((*matched)->T_map_vehicle.translation() - truth.translation()).norm(), 0.1);
  const Eigen::Isometry3d off = on_street(kLength + 13, 0, 0);
  EXPECT_FALSE(matcher.nearest_keyframe(off));
  EXPECT_FALSE(*matcher.match_near(seen_at(street(), off), off));
}

}  // namespace
}  // namespace infuse::places
