#include "fusion/calibration/distributions.hpp"

#include <gtest/gtest.h>

namespace infuse::calibration {
namespace {

TEST(ChiSquaredExceeded, MatchesTables) {
  EXPECT_NEAR(chi_squared_exceeded(12.5916, 6), 0.05, 1e-5);
  EXPECT_NEAR(chi_squared_exceeded(22.4577, 6), 0.001, 1e-6);
  EXPECT_NEAR(chi_squared_exceeded(21.0261, 12), 0.05, 1e-5);
  EXPECT_NEAR(chi_squared_exceeded(79.0819, 60), 0.05, 1e-5);
  EXPECT_EQ(chi_squared_exceeded(0, 6), 1);
  EXPECT_EQ(chi_squared_exceeded(5, 0), 1);
  EXPECT_EQ(chi_squared_exceeded(1e6, 6), 0);
}

TEST(Fisher6Exceeded, MatchesTables) {
  EXPECT_NEAR(fisher6_exceeded(6.1631, 4), 0.05, 1e-5);
  EXPECT_NEAR(fisher6_exceeded(3.2172, 10), 0.05, 1e-5);
  EXPECT_NEAR(fisher6_exceeded(2.1750, 120), 0.05, 1e-5);
  EXPECT_EQ(fisher6_exceeded(0, 12), 1);
}

TEST(WideningOfFew, MatchesTablesOfFishersDistribution) {
  // 95 % quantiles of F(6, n): 6.1631, 3.2172, 2.5990, 2.1750; of chi-square(6): 12.5916.
  EXPECT_NEAR(widening_of_few(4), 6 * 6.1631 / 12.5916, 1e-3);
  EXPECT_NEAR(widening_of_few(10), 6 * 3.2172 / 12.5916, 1e-3);
  EXPECT_NEAR(widening_of_few(20), 6 * 2.5990 / 12.5916, 1e-3);
  EXPECT_NEAR(widening_of_few(120), 6 * 2.1750 / 12.5916, 1e-3);
  EXPECT_NEAR(widening_of_few(1e7), 1, 1e-4);
}

}  // namespace
}  // namespace infuse::calibration
