#include "fusion/places/outline_alignment.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/places/invented_places.hpp"

namespace infuse::places {
namespace {

// On the other side of the street, against its direction, and with a heading that is off.
TEST(OutlineAlignment, FindsShiftsOfAFewMetresAboutAGuessOfTheHeading) {
  const InventedStreet street(3);
  const Eigen::Isometry3d T_map_target = on_street(70, -2, 0);
  const mapping::Submap target = street.seen_from(T_map_target * lidar_above(), 1);
  for (const double along : {66.0, 70.3, 74.0}) {
    for (const double across : {-2.0, 3.5}) {
      for (const double yaw : {0.06, 3.14159}) {
        const Eigen::Isometry3d T_map_source = on_street(along, across, yaw);
        const mapping::Submap source = street.seen_from(T_map_source * lidar_above(), 2);
        const Eigen::Isometry3d found = align_outlines(
            target.points(), lidar_above(), source.points(), lidar_above(), yaw > 1 ? 3.07 : 0);
        const Eigen::Isometry3d error = (T_map_target.inverse() * T_map_source).inverse() * found;
        EXPECT_LT(error.translation().head<2>().norm(), 1)
            << along << ", " << across << ", " << yaw;
        EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.06);
      }
    }
  }
}

TEST(OutlineAlignment, OfNothingIsTheGuess) {
  const Eigen::Isometry3d found = align_outlines({}, lidar_above(), {}, lidar_above(), 0.5);
  EXPECT_EQ(found.translation().norm(), 0);
  EXPECT_NEAR(Eigen::AngleAxisd(found.linear()).angle(), 0.5, 1e-12);
}

}  // namespace
}  // namespace infuse::places
