#include "fusion/dependence/count_entropy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "fusion/dependence/shrunk_information.hpp"

namespace infuse::dependence {
namespace {

constexpr double kEntropyTolerance = 5e-13;  // the reference values have twelve decimals
const std::vector<double> kSmallCounts = {4, 2, 3, 0, 2, 4, 0, 0, 2, 1, 1};
const std::vector<double> kSkewedCounts = {100, 50, 25, 12, 6, 3, 1, 1, 1, 0};

// Reference values: R package `entropy` 1.3.2.
TEST(CountEntropy, MaximumLikelihoodAndMillerMadowAgreeWithReference) {
  EXPECT_NEAR(entropy_maximum_likelihood(kSmallCounts).value, 1.968382408728, kEntropyTolerance);
  EXPECT_NEAR(entropy_maximum_likelihood(kSmallCounts).value / std::log(2), 2.839775539646,
              kEntropyTolerance);
  EXPECT_NEAR(entropy_miller_madow(kSmallCounts).value, 2.152592935044, kEntropyTolerance);
  EXPECT_TRUE(entropy_maximum_likelihood(kSmallCounts).usable());
}

TEST(CountEntropy, ChaoShenAgreesWithReference) {
  EXPECT_NEAR(entropy_chao_shen(kSmallCounts).value, 2.201137101280, kEntropyTolerance);
  EXPECT_NEAR(entropy_chao_shen(kSmallCounts).value / std::log(2), 3.175569580333,
              kEntropyTolerance);
  EXPECT_NEAR(entropy_chao_shen(kSkewedCounts).value, 1.416122833810, kEntropyTolerance);
  EXPECT_NEAR(entropy_chao_shen(std::vector<double>{10, 1}).value, 0.493770428333,
              kEntropyTolerance);
  EXPECT_NEAR(entropy_chao_shen(std::vector<double>{5, 5, 5, 5}).value, 1.390704580088,
              kEntropyTolerance);
  EXPECT_EQ(entropy_chao_shen(std::vector<double>{1}).value, 0);
  const Estimate singletons = entropy_chao_shen(std::vector<double>{1, 1, 1, 1, 1});
  EXPECT_NEAR(singletons.value, 3.486890381894, kEntropyTolerance);
  EXPECT_TRUE(singletons.usable());
}

TEST(CountEntropy, JamesSteinAgreesWithReference) {
  const ShrunkFrequencies shrunk = james_stein_frequencies(kSmallCounts);
  EXPECT_NEAR(shrunk.lambda, 0.766393442623, kEntropyTolerance);
  const std::vector<double> expected = {0.1188524590, 0.0942622951, 0.1065573770, 0.0696721311,
                                        0.0942622951, 0.1188524590, 0.0696721311, 0.0696721311,
                                        0.0942622951, 0.0819672131, 0.0819672131};
  EXPECT_THAT(shrunk.frequencies, testing::Pointwise(testing::DoubleNear(5e-11), expected));
  EXPECT_NEAR(entropy_james_stein(kSmallCounts).value, 2.379602895310, kEntropyTolerance);
  EXPECT_NEAR(entropy_james_stein(kSkewedCounts).value, 1.405388823447, kEntropyTolerance);
  EXPECT_NEAR(james_stein_frequencies(kSkewedCounts).lambda, 0.014187121242, kEntropyTolerance);
  EXPECT_NEAR(entropy_james_stein(std::vector<double>{5, 5, 5, 5}).value, 1.386294361120,
              kEntropyTolerance);
  EXPECT_NEAR(entropy_james_stein(std::vector<double>{1, 0, 0}).value, 1.098612288668,
              kEntropyTolerance);
}

TEST(CountEntropy, PlugInOfKnownDistribution) {
  const std::vector<double> p = {0.5, 0.25, 0.125, 0.125};
  EXPECT_NEAR(plug_in_entropy(p), 1.2130075659799, 5e-14);
  EXPECT_NEAR(plug_in_entropy(p), 1.75 * std::log(2), 1e-15);
}

TEST(CountEntropy, GivenTargetAndShrinkageAreTheWeightedAverage) {
  const std::vector<double> counts = {3, 1}, target = {0.2, 0.8};
  const ShrunkFrequencies shrunk =
      james_stein_frequencies(counts, {.target = target, .lambda = 0.25});
  EXPECT_NEAR(shrunk.frequencies[0], 0.25 * 0.2 + 0.75 * 0.75, 1e-15);
  EXPECT_NEAR(shrunk.frequencies[1], 0.25 * 0.8 + 0.75 * 0.25, 1e-15);
  // λ_s = Σ p(1−p)/(n−1) / Σ (t−p)², by hand.
  const double optimal = james_stein_frequencies(counts, {.target = target, .lambda = {}}).lambda;
  EXPECT_NEAR(optimal, 2 * (0.75 * 0.25 / 3) / (2 * 0.55 * 0.55), 1e-15);
}

TEST(CountEntropy, FastShrinkageAsPrintedGrowsAndReversedFalls) {
  EXPECT_EQ(fast_shrinkage(0, 1000, FastShrinkage::kAsPrinted), 0);
  EXPECT_EQ(fast_shrinkage(0, 1000, FastShrinkage::kReversed), 1);
  const double printed = 2 / (1 + std::exp(-1.5)) - 1;
  EXPECT_NEAR(fast_shrinkage(1500, 1000, FastShrinkage::kAsPrinted), printed, 1e-15);
  EXPECT_NEAR(fast_shrinkage(1500, 1000, FastShrinkage::kReversed), 1 - printed, 1e-15);
  EXPECT_EQ(fast_shrinkage(NAN, 1000), 1);
  EXPECT_EQ(fast_shrinkage(10, 0), 1);
}

// Direction of P(4.11): root mean square error of the entropy of codeword histograms.
TEST(CountEntropy, FastShrinkageWorksReversedNotAsPrinted) {
  constexpr int kWords = 64, kTrials = 50;
  constexpr double kSigma = 100;
  std::vector<double> truth(kWords);
  double total = 0;
  for (int k = 0; k < kWords; ++k) total += truth[size_t(k)] = 1.0 / (k + 1);
  for (double& p : truth) p /= total;
  const double exact = plug_in_entropy(truth);
  std::mt19937 random(3);
  std::discrete_distribution<size_t> draw(truth.begin(), truth.end());
  const auto error = [&](int n, std::span<const double> target, FastShrinkage direction) {
    double squared = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<double> counts(kWords, 0.0);
      for (int i = 0; i < n; ++i) counts[draw(random)] += 1;
      const double lambda = fast_shrinkage(n, kSigma, direction);
      const double h = entropy_james_stein(counts, {.target = target, .lambda = lambda}).value;
      squared += (h - exact) * (h - exact);
    }
    return std::sqrt(squared / kTrials);
  };
  // Many correspondences and a wrong target: the samples must prevail.
  EXPECT_LT(error(1000, {}, FastShrinkage::kReversed), 0.1);
  EXPECT_GT(error(1000, {}, FastShrinkage::kAsPrinted), 0.5);
  // Few correspondences and a target from training: the target must prevail.
  EXPECT_LT(error(20, truth, FastShrinkage::kReversed), 0.1);
  EXPECT_GT(error(20, truth, FastShrinkage::kAsPrinted), 0.5);
}

TEST(CountEntropy, BadCountsGiveAReasonAndAFiniteValue) {
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<double>> bad = {{}, {0, 0}, {-1, 2}, {NAN, 1}, {inf, 1}, {1e300}};
  using Estimator = CountEntropyOptions::Estimator;
  for (const auto& counts : bad) {
    for (const Estimator estimator : {Estimator::kMaximumLikelihood, Estimator::kMillerMadow,
                                      Estimator::kJamesStein, Estimator::kChaoShen}) {
      const Estimate h = entropy(counts, {.estimator = estimator, .shrinkage = {}});
      EXPECT_FALSE(h.usable());
      EXPECT_TRUE(std::isfinite(h.value));
    }
  }
  EXPECT_FALSE(entropy_chao_shen(std::vector<double>{1.5, 2}).usable());
  EXPECT_FALSE(entropy_james_stein(kSmallCounts, {.target = {}, .lambda = 1.5}).usable());
  EXPECT_FALSE(entropy_james_stein(kSmallCounts, {.target = kSmallCounts, .lambda = {}}).usable());
}

TEST(CountEntropy, OnlyThePlugInRejectsFewerObservationsThanWords) {
  const std::vector<double> sparse = {1, 0, 2, 0, 0};
  EXPECT_THAT(std::string(entropy_maximum_likelihood(sparse).reason),
              testing::HasSubstr("fewer observations than words"));
  EXPECT_FALSE(entropy_miller_madow(sparse).usable());
  EXPECT_TRUE(entropy_james_stein(sparse).usable());
  EXPECT_TRUE(entropy_chao_shen(sparse).usable());
}

TEST(CountEntropy, RelabellingChangesNothing) {
  std::vector<double> reversed(kSmallCounts.rbegin(), kSmallCounts.rend());
  using Estimator = CountEntropyOptions::Estimator;
  for (const Estimator estimator : {Estimator::kMaximumLikelihood, Estimator::kMillerMadow,
                                    Estimator::kJamesStein, Estimator::kChaoShen}) {
    const CountEntropyOptions options{.estimator = estimator, .shrinkage = {}};
    EXPECT_NEAR(entropy(kSmallCounts, options).value, entropy(reversed, options).value, 1e-13);
  }
}

}  // namespace
}  // namespace infuse::dependence
