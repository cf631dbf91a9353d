#include "drivers/measurement/stamp.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace infuse {
namespace {

TEST(Stamp, DifferenceAndSumAreExactAtEpochScale) {
  const Stamp a = Stamp::from_ns(1'795'216'680'123'456'789);
  const Stamp b = a + Duration(1);
  EXPECT_EQ((b - a).count(), 1);
  EXPECT_LT(a, b);
  EXPECT_EQ(b - Duration(1), a);
}

TEST(Stamp, ArithmeticSaturatesInsteadOfOverflowing) {
  EXPECT_EQ(Stamp::latest() + Duration(1), Stamp::latest());
  EXPECT_EQ(Stamp::earliest() + Duration(-1), Stamp::earliest());
  EXPECT_EQ(Stamp::earliest() - Duration::min(), Stamp::latest());
  EXPECT_EQ(Stamp::latest() - Stamp::earliest(), Duration::max());
  EXPECT_EQ(Stamp::earliest() - Stamp::latest(), Duration::min());
}

TEST(Stamp, SecondsRoundToTheNearestNanosecondAndSaturate) {
  EXPECT_EQ(from_seconds(0.1).count(), 100'000'000);
  EXPECT_EQ(from_seconds(-1e-9).count(), -1);
  EXPECT_EQ(from_seconds(1e300), Duration::max());
  EXPECT_EQ(from_seconds(-1e300), Duration::min());
  EXPECT_EQ(from_seconds(std::nan("")), Duration::zero());
  EXPECT_DOUBLE_EQ(to_seconds(Duration(1'500'000'000)), 1.5);
}

}  // namespace
}  // namespace infuse
