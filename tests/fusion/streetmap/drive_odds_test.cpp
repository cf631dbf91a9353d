#include "fusion/streetmap/drive_odds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace infuse::streetmap {
namespace {

/// A place that one hypothesis in 10 000 is not at, known to 2 m along x and 1 m along y.
FoundPlace found_place(bool sure) {
  FoundPlace found;
  found.pose = {100, 50, 0};
  found.covariance.diagonal() << 4, 1, 0.01;
  found.elsewhere = 1e-4;
  found.sure = sure;
  return found;
}

TEST(DriveOdds, ASurePlaceRefutesAllElse) {
  const FoundPlace found = found_place(true);
  const DriveOdds odds(found, {}, found.pose);
  EXPECT_EQ(odds(found.pose), 0);
  EXPECT_NEAR(odds({104, 50, 0}), -2, 1e-12);                             // two sigma along
  EXPECT_NEAR(odds({100, 53, 0}), -4.5, 1e-12);                           // three across
  EXPECT_NEAR(odds({100, 50, std::numbers::pi}), std::log(1e-4), 1e-12);  // reversed
  EXPECT_NEAR(odds({300, 50, 0}), std::log(1e-4), 1e-12);
  // Against an estimate two sigma off, the place itself is the likelier.
  EXPECT_NEAR(DriveOdds(found, {}, {104, 50, 0})(found.pose), 2, 1e-12);
}

TEST(DriveOdds, UntilItIsSureTheDriveMayBeBesideTheStreets) {
  const FoundPlace found = found_place(false);
  const DriveOdds odds(found, {}, found.pose);
  EXPECT_EQ(odds(found.pose), 0);
  EXPECT_NEAR(odds({300, 50, 0}), std::log(0.05 + 0.95e-4), 1e-12);
}

TEST(DriveOdds, SaysNothingWhereNoPlaceAloneExplainsTheDrive) {
  const FoundPlace found = found_place(true);
  const PlanarPose elsewhere{300, 50, 0};
  EXPECT_EQ(DriveOdds(std::nullopt, {}, found.pose)(elsewhere), 0);
  EXPECT_EQ(DriveOdds(found, {}, elsewhere)(found.pose), 0);  // the estimate is not there
  FoundPlace doubtful = found;
  doubtful.elsewhere = 0.2;
  EXPECT_EQ(DriveOdds(doubtful, {}, found.pose)(elsewhere), 0);
  FoundPlace beside = found;
  beside.misfit = 0.1;
  EXPECT_EQ(DriveOdds(beside, {}, found.pose)(elsewhere), 0);
}

}  // namespace
}  // namespace infuse::streetmap
