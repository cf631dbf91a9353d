#include "fusion/places/place_descriptor.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "fusion/places/place_index.hpp"
#include "tests/fusion/places/invented_places.hpp"

namespace infuse::places {
namespace {

PlaceDescriptor descriptor_at(const InventedStreet& street, const Eigen::Isometry3d& T_map_vehicle,
                              uint64_t seed) {
  return describe_place(street.seen_from(T_map_vehicle * lidar_above(), seed).points(),
                        lidar_above());
}

TEST(PlaceDescriptor, HasTheHighestPointOfEachCellAboveTheGround) {
  const FieldVector<float> x{10, 10, 0, 3}, y{0, 0.1F, -30, 3}, z{0.5F, 2.2F, 20, -1.8F};
  const PlaceDescriptor place = describe_place({x, y, z}, lidar_above());
  // The lidar is 1 m ahead of the vehicle and its ground 1.8 m below.
  EXPECT_NEAR(place.heights(2, 0), 4.0, 0.03);
  EXPECT_FLOAT_EQ(place.heights(7, 45), static_cast<float>(kMaxDescribedHeight));
  EXPECT_EQ((place.heights.array() > 0).count(), 2);
}

TEST(PlaceDescriptor, TurningTheVehicleShiftsItAndLeavesItsKey) {
  const InventedStreet street(1);
  const PlaceDescriptor ahead = descriptor_at(street, on_street(80, 0, 0), 1);
  for (const int sectors : {0, 7, 30, 44}) {
    const double yaw = 2 * std::numbers::pi * sectors / kSectors;
    const PlaceDescriptor turned = descriptor_at(street, on_street(80, 0, yaw), 2);
    const PlaceSimilarity similarity = compare_places(ahead, turned);
    EXPECT_NEAR(std::remainder(similarity.yaw - yaw, 2 * std::numbers::pi), 0, 1e-6);
    EXPECT_GT(similarity.correlation, 0.9);
    EXPECT_GT(key_of(ahead).dot(key_of(turned)), 0.98F);
  }
}

TEST(PlaceDescriptor, OfNothingIsAlikeToNothing) {
  const PlaceDescriptor none = describe_place({}, lidar_above());
  const PlaceDescriptor place = descriptor_at(InventedStreet(1), on_street(80, 0, 0), 1);
  EXPECT_EQ(key_of(none).norm(), 0);
  EXPECT_EQ(compare_places(none, place).correlation, 0);
  const float nan = std::nanf("");
  const FieldVector<float> bad{nan};
  EXPECT_EQ(describe_place({bad, bad, bad}, lidar_above()).heights.norm(), 0);
}

// The places that were driven through, seen 1 m beside and in any direction.
TEST(PlaceIndex, FindsThePlaceAmongTheFirst) {
  const InventedStreet street(2);
  std::vector<PlaceDescriptor> places;
  for (int k = 0; k < 90; ++k) places.push_back(descriptor_at(street, on_street(2.0 * k, 0, 0), 3));
  const PlaceIndex index(places);
  for (const double along : {11.0, 63.0, 100.0, 155.0}) {
    for (const double yaw : {0.1, 1.7, 3.1, -2.0}) {
      const auto found = index.find(descriptor_at(street, on_street(along, 1, yaw), 4), 5);
      ASSERT_EQ(found.size(), 5U);
      EXPECT_NEAR(2.0 * static_cast<double>(found[0].place), along, 4) << along << ", " << yaw;
      EXPECT_NEAR(std::remainder(found[0].similarity.yaw - yaw, 2 * std::numbers::pi), 0, 0.12);
      for (size_t i = 1; i < found.size(); ++i) {
        EXPECT_LE(found[i].similarity.correlation, found[i - 1].similarity.correlation);
      }
    }
  }
  EXPECT_TRUE(PlaceIndex({}).find(places[0], 3).empty());
}

}  // namespace
}  // namespace infuse::places
