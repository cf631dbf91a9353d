#include "tests/study/dependence/sample_entropy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

namespace infuse::study {
namespace {

constexpr double kTwoPiE = 2 * std::numbers::pi * std::numbers::e;
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

Eigen::MatrixXd gaussian(int d, int n, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> draw;
  return Eigen::MatrixXd::NullaryExpr(d, n, [&] { return draw(random); });
}

Eigen::MatrixXd uniform(int d, int n, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> draw;
  return Eigen::MatrixXd::NullaryExpr(d, n, [&] { return draw(random); });
}

std::span<const double> row(const Eigen::MatrixXd& scalars) {
  return {scalars.data(), static_cast<size_t>(scalars.size())};
}

/// Mean of `trials` values of `estimate(seed)` and its standard error.
struct Mean {
  double value, standard_error;
};
Mean mean_over_seeds(int trials, const std::function<Estimate(unsigned)>& estimate) {
  double sum = 0, squared = 0;
  for (int t = 0; t < trials; ++t) {
    const Estimate h = estimate(static_cast<unsigned>(t) + 1);
    EXPECT_TRUE(h.usable()) << h.reason;
    sum += h.value;
    squared += h.value * h.value;
  }
  const double mean = sum / trials;
  return {mean, std::sqrt((squared / trials - mean * mean) / (trials - 1))};
}

TEST(SpacingEntropy, IsThePrintedFormulaByHand) {
  // n = 4, m = 1: spacings 1, 3, 6, 5 with the ends clamped; n/2m = 2.
  const std::vector<double> x = {7, 0, 1, 3};
  const double expected =
      (std::log(2.0 * 1) + std::log(2.0 * 3) + std::log(2.0 * 6) + std::log(2.0 * 4)) / 4;
  EXPECT_NEAR(entropy_spacing(x, {.m = 1, .correct_bias = false}).value, expected, 1e-14);
}

TEST(SpacingEntropy, UniformWithinStandardErrorAtAnySpacing) {
  for (const int m : {1, 3, 10}) {
    const Mean h = mean_over_seeds(400, [&](unsigned seed) {
      return entropy_spacing(row(3 * uniform(1, 50, seed)), {.m = m, .correct_bias = true});
    });
    EXPECT_NEAR(h.value, std::log(3), 4 * h.standard_error) << m;
  }
}

TEST(SpacingEntropy, GaussianWithinStandardError) {
  const Mean h = mean_over_seeds(20, [](unsigned seed) {
    return entropy_spacing(row(gaussian(1, 20000, seed)), {.m = 20, .correct_bias = true});
  });
  EXPECT_NEAR(h.value, std::log(kTwoPiE) / 2, 4 * h.standard_error);
}

TEST(SpacingEntropy, BadInputGivesAReason) {
  const std::vector<double> constant(10, 2.0);
  EXPECT_FALSE(entropy_spacing({}).usable());
  EXPECT_FALSE(entropy_spacing(constant).usable());
  EXPECT_FALSE(entropy_spacing(std::vector<double>{1, 2, kNotANumber, 3}).usable());
  EXPECT_FALSE(entropy_spacing(std::vector<double>{-1e308, 1, 1e308}).usable());
  EXPECT_FALSE(
      entropy_spacing(std::vector<double>{1, 2, 3, 4}, {.m = 2, .correct_bias = true}).usable());
  EXPECT_FALSE(
      entropy_spacing(std::vector<double>{1, 1, 1, 1, 1, 2, 3}, {.m = 1, .correct_bias = true})
          .usable());
  EXPECT_TRUE(entropy_spacing(std::vector<double>{1, 2, 3}).usable());
}

TEST(NearestNeighbourEntropy, IsThePrintedFormulaInOneDimension) {
  const Eigen::RowVector4d x(0, 1, 3, 7);  // distances 1, 1, 2, 4
  const double mean_log = (std::log(4.0 * 1) * 2 + std::log(4.0 * 2) + std::log(4.0 * 4)) / 4;
  EXPECT_NEAR(entropy_nearest_neighbour(x).value, mean_log + std::log(2) + std::numbers::egamma,
              1e-14);
}

TEST(NearestNeighbourEntropy, GaussianWithinStandardError) {
  for (const int d : {1, 2, 3}) {
    for (const int k : {1, 4}) {
      const Mean h = mean_over_seeds(
          12, [&](unsigned seed) { return entropy_nearest_neighbour(gaussian(d, 4000, seed), k); });
      // The bias decreases as n^(-2/d): allow for it in three dimensions.
      const double bias = d == 3 ? 0.02 : 0.002;
      EXPECT_NEAR(h.value, d * std::log(kTwoPiE) / 2, 4 * h.standard_error + bias)
          << "d " << d << " k " << k;
    }
  }
}

TEST(NearestNeighbourEntropy, UniformWithinStandardError) {
  const Mean h = mean_over_seeds(
      20, [](unsigned seed) { return entropy_nearest_neighbour(2 * uniform(1, 4000, seed), 3); });
  EXPECT_NEAR(h.value, std::log(2), 4 * h.standard_error + 0.001);
}

TEST(NearestNeighbourEntropy, ScalingAddsDimensionsTimesTheLogarithm) {
  const Eigen::MatrixXd x = gaussian(3, 200, 1);
  EXPECT_NEAR(entropy_nearest_neighbour(5 * x, 2).value,
              entropy_nearest_neighbour(x, 2).value + 3 * std::log(5), 1e-12);
}

TEST(NearestNeighbourEntropy, BadInputGivesAReason) {
  Eigen::MatrixXd x = gaussian(2, 10, 1);
  EXPECT_FALSE(entropy_nearest_neighbour(x, 0).usable());
  EXPECT_FALSE(entropy_nearest_neighbour(x, 10).usable());
  EXPECT_FALSE(entropy_nearest_neighbour(Eigen::MatrixXd(2, 0)).usable());
  EXPECT_FALSE(entropy_nearest_neighbour(Eigen::MatrixXd(0, 10)).usable());
  EXPECT_FALSE(entropy_nearest_neighbour(Eigen::MatrixXd::Ones(2, 10)).usable());
  EXPECT_FALSE(entropy_nearest_neighbour(1e200 * x).usable());
  x(1, 3) = kNotANumber;
  EXPECT_FALSE(entropy_nearest_neighbour(x).usable());
}

TEST(SpanningTreeEntropy, LengthAgreesWithATreeByHand) {
  // Points on a line at 0, 1, 4, 9: edges 1, 3, 5; d = 1, alpha = 0.5, so gamma = 0.5.
  const Eigen::RowVector4d x(9, 0, 4, 1);
  const double length = 1 + std::sqrt(3) + std::sqrt(5);
  const SpanningTreeOptions options{
      .alpha = 0.5, .log_beta = 0.25, .calibration_sets = 1, .seed = 1};
  EXPECT_NEAR(renyi_entropy_spanning_tree(x, options).value, 2 * (std::log(length / 2) - 0.25),
              1e-13);
}

TEST(SpanningTreeEntropy, LogBetaOfALineIsTheMomentOfItsSpacings) {
  // The n spacings are exponential: E L = n^α Γ(1 + γ), γ = 1 − α.
  SpanningTreeOptions options;
  options.alpha = 0.3;
  options.calibration_sets = 40;
  EXPECT_NEAR(spanning_tree_log_beta(1, 1000, options), std::lgamma(1.7), 0.005);
}

TEST(SpanningTreeEntropy, GaussianAgreesWithClosedForm) {
  // ½ ln (2π)^d |Σ| + d/2 ln α/(α − 1).
  for (const double alpha : {0.5, 0.8}) {
    SpanningTreeOptions options;
    options.alpha = alpha;
    options.log_beta = spanning_tree_log_beta(2, 1000, options);
    const Mean h = mean_over_seeds(8, [&](unsigned seed) {
      return renyi_entropy_spanning_tree(3 * gaussian(2, 1000, seed), options);
    });
    const double truth =
        std::log(2 * std::numbers::pi) + std::log(9) + std::log(alpha) / (alpha - 1);
    EXPECT_NEAR(h.value, truth, 4 * h.standard_error + 0.1) << alpha;
  }
}

TEST(SpanningTreeEntropy, SameSeedSameBytes) {
  const Eigen::MatrixXd x = gaussian(2, 100, 1);
  EXPECT_EQ(renyi_entropy_spanning_tree(x).value, renyi_entropy_spanning_tree(x).value);
}

TEST(SpanningTreeEntropy, BadInputGivesAReason) {
  Eigen::MatrixXd x = gaussian(2, 10, 1);
  EXPECT_FALSE(renyi_entropy_spanning_tree(Eigen::MatrixXd(2, 0)).usable());
  EXPECT_FALSE(renyi_entropy_spanning_tree(Eigen::MatrixXd(0, 5)).usable());
  EXPECT_FALSE(renyi_entropy_spanning_tree(Eigen::MatrixXd::Ones(2, 10)).usable());
  EXPECT_FALSE(renyi_entropy_spanning_tree(Eigen::MatrixXd::Zero(2, 50001)).usable());
  SpanningTreeOptions options;
  options.alpha = 1;
  EXPECT_FALSE(renyi_entropy_spanning_tree(x, options).usable());
  x(0, 0) = kNotANumber;
  EXPECT_FALSE(renyi_entropy_spanning_tree(x).usable());
}

}  // namespace
}  // namespace infuse::study
