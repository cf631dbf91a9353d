#include "fusion/places/place_probability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace infuse::places {
namespace {

constexpr PlaceFit kGood{0.9, 0.98}, kFair{0.62, 0.92};

double sum(const PlaceProbabilities& p) { return p.best + p.runner_up + p.nowhere; }

TEST(PlaceProbability, IsNowhereWithoutAPlaceThatFits) {
  const PlaceProbabilities p = place_probabilities({});
  EXPECT_EQ(p.nowhere, 1);
  EXPECT_EQ(p.best, 0);
}

TEST(PlaceProbability, OfOnePlaceIsTheLogisticFunctionOfItsOdds) {
  for (const PlaceFit& fit : {kGood, kFair}) {
    const PlaceProbabilities p = place_probabilities(std::vector{fit});
    EXPECT_NEAR(p.best, 1 / (1 + std::exp(-log_odds(fit))), 1e-12);
    EXPECT_NEAR(sum(p), 1, 1e-12);
  }
}

TEST(PlaceProbability, TwoPlacesThatFitAlikeShareIt) {
  const PlaceProbabilities p = place_probabilities(std::vector{kGood, kGood});
  EXPECT_NEAR(p.best, p.runner_up, 1e-12);
  EXPECT_LT(p.best, 0.5);
  EXPECT_NEAR(sum(p), 1, 1e-12);
}

TEST(PlaceProbability, GrowsWithInliersAndAgreement) {
  const double odds = log_odds(kFair);
  EXPECT_GT(log_odds({kFair.inliers + 0.1, kFair.agreement}), odds);
  EXPECT_GT(log_odds({kFair.inliers, kFair.agreement + 0.05}), odds);
}

TEST(PlaceProbability, SaysNothingOfWhatHasNothingInCommon) {
  EXPECT_LT(place_probabilities(std::vector{PlaceFit{0.5, 0.85}}).best, 0.25);
  EXPECT_GT(place_probabilities(std::vector{kGood}).best, 0.99);
}

}  // namespace
}  // namespace infuse::places
