#include "tests/study/dependence/nemenman.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/study/dependence/count_entropy.hpp"

namespace infuse::study {
namespace {

/// ψ by finite differences of std::lgamma: crude, but independent of the library's.
double psi(double x) {
  const double h = 1e-4 * std::max(x, 1.0);
  if (x < 1) return psi(x + 1) - 1 / x;
  return (8 * (std::lgamma(x + h) - std::lgamma(x - h)) -
          (std::lgamma(x + 2 * h) - std::lgamma(x - 2 * h))) /
         (12 * h);
}

/// Two words: posterior mean of H(p) by quadrature over p and over ξ(β), from the definition of the
/// prior.
double two_words_by_quadrature(double n1, double n2) {
  const auto xi = [](double beta) { return psi(2 * beta + 1) - psi(beta + 1); };
  double mass = 0, mean = 0;
  constexpr int kPointCount = 4000;
  constexpr double kStep = 0.02;
  for (double u = -13; u < 13; u += kStep) {
    const double beta = std::exp(u);
    const double weight = xi(std::exp(u + kStep / 2)) - xi(std::exp(u - kStep / 2));
    const double log_norm = std::lgamma(2 * beta) - 2 * std::lgamma(beta);
    for (int i = 0; i < kPointCount; ++i) {
      // p = 1/(1 + e^{-z}) puts points close to both ends.
      const double z = -60 + 120 * (i + 0.5) / kPointCount;
      const double p = 1 / (1 + std::exp(-z)), q = 1 / (1 + std::exp(z));
      const double density =
          std::exp(log_norm + (n1 + beta) * std::log(p) + (n2 + beta) * std::log(q));
      mass += weight * density;
      mean += weight * density * (-p * std::log(p) - q * std::log(q));
    }
  }
  return mean / mass;
}

TEST(Nemenman, AgreesWithQuadratureOverTheDistributionItself) {
  for (const auto& [a, b] : {std::pair{3.0, 1.0}, {7.0, 7.0}, {20.0, 2.0}}) {
    EXPECT_NEAR(entropy_nemenman(std::vector<double>{a, b}).value, two_words_by_quadrature(a, b),
                2e-4)
        << a << " " << b;
  }
}

// Example of simomarsili/ndd, an independent implementation (with adaptive quadrature).
TEST(Nemenman, AgreesWithPublishedExample) {
  std::vector<double> counts = {4, 12, 4, 5, 3, 1, 5, 1, 2, 2, 2, 2, 11, 3, 4, 12, 12, 1, 2};
  counts.resize(100, 0.0);
  EXPECT_NEAR(entropy_nemenman(counts).value, 2.8060922529931225, 1e-5);
}

TEST(Nemenman, ErrsLessThanPlugInWhereWordsOutnumberObservations) {
  std::mt19937 random(1);
  double nemenman = 0, plug_in = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> counts(500, 0.0);
    std::uniform_int_distribution<size_t> draw(0, 499);
    for (int i = 0; i < 100; ++i) counts[draw(random)] += 1;
    nemenman += std::abs(entropy_nemenman(counts).value - std::log(500));
    plug_in += std::abs(entropy_maximum_likelihood(counts).value - std::log(500));
  }
  EXPECT_LT(nemenman, 0.3 * plug_in);
}

TEST(Nemenman, ConvergesToTheTruthWithManyObservations) {
  const std::vector<double> counts = {50000, 25000, 12500, 12500};
  EXPECT_NEAR(entropy_nemenman(counts).value, 1.2130075659799, 1e-4);
}

TEST(Nemenman, OneWordHasNoEntropy) {
  EXPECT_EQ(entropy_nemenman(std::vector<double>{7}).value, 0);
  EXPECT_TRUE(entropy_nemenman(std::vector<double>{7}).usable());
}

TEST(Nemenman, StaysBetweenZeroAndLogOfTheVocabulary) {
  for (const auto& counts : std::vector<std::vector<double>>{
           {1, 0, 0, 0}, {1e6, 0, 0}, {1, 1, 1, 1, 1}, {0.5, 0.25}, {1e15, 1e15}}) {
    const Estimate h = entropy_nemenman(counts);
    EXPECT_TRUE(h.usable());
    EXPECT_GE(h.value, 0);
    EXPECT_LE(h.value, std::log(double(counts.size())));
  }
}

}  // namespace
}  // namespace infuse::study
