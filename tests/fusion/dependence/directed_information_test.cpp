#include "fusion/dependence/directed_information.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <vector>

namespace infuse::dependence {
namespace {

using Labels = std::vector<int32_t>;
constexpr auto kMaximumLikelihood = CountEntropyOptions::Estimator::kMaximumLikelihood;

double binary_entropy(double p) { return -p * std::log(p) - (1 - p) * std::log(1 - p); }

/// X is a fair coin; Y_i = X_{i − delay}, flipped with probability `noise`.
struct Channel {
  Labels x, y;
  Channel(size_t n, size_t delay, double noise) : x(n), y(n) {
    std::mt19937 random(7);
    std::bernoulli_distribution coin(0.5), flip(noise);
    for (size_t i = 0; i < n; ++i) {
      x[i] = coin(random);
      y[i] = (i >= delay ? x[i - delay] : 0) ^ static_cast<int32_t>(flip(random));
    }
  }
};

TEST(DirectedInformationRate, NoisyChannelHasItsCapacityOneWayAndNothingTheOther) {
  const Channel channel(200000, 1, 0.1);
  const double capacity = std::log(2) - binary_entropy(0.1);
  EXPECT_NEAR(directed_information_rate(channel.x, channel.y, 1).value, capacity, 0.005);
  EXPECT_NEAR(directed_information_rate(channel.y, channel.x, 1).value, 0, 0.001);
  EXPECT_NEAR(directed_information_rate(channel.x, channel.y, 0).value, 0, 0.001);
}

TEST(DirectedInformationRate, DelayedLeavesThePresentOut) {
  const Channel channel(100000, 0, 0.2);
  const double capacity = std::log(2) - binary_entropy(0.2);
  EXPECT_NEAR(directed_information_rate(channel.x, channel.y, 1).value, capacity, 0.005);
  EXPECT_NEAR(directed_information_rate(channel.x, channel.y, 1, kMaximumLikelihood, true).value, 0,
              0.001);
}

/// Entropy of words made of some positions of each observation, computed with a map.
double word_entropy(const std::vector<Labels>& words) {
  std::map<Labels, double> counts;
  for (const Labels& word : words) counts[word] += 1;
  double h = 0;
  for (const auto& [word, count] : counts) {
    const double p = count / double(words.size());
    h -= p * std::log(p);
  }
  return h;
}

TEST(DirectedInformation, AgreesWithTheDefinitionAndConservesInformation) {
  std::mt19937 random(3);
  constexpr int kLength = 3;
  constexpr size_t kObservations = 200;
  Labels x(kObservations * kLength), y(kObservations * kLength);
  for (size_t i = 0; i < x.size(); ++i) {
    x[i] = int32_t(random() % 3) - 1;
    y[i] = (i > 0 && random() % 2) ? x[i - 1] : int32_t(random() % 2);
  }
  // Words of the first `nx` labels of x and the first `ny` of y.
  const auto h = [&](size_t nx, size_t ny) {
    std::vector<Labels> words(kObservations);
    for (size_t i = 0; i < kObservations; ++i) {
      for (size_t k = 0; k < nx; ++k) words[i].push_back(x[i * kLength + k]);
      words[i].push_back(99);
      for (size_t k = 0; k < ny; ++k) words[i].push_back(y[i * kLength + k]);
    }
    return word_entropy(words);
  };
  double expected = 0;
  for (size_t i = 1; i <= kLength; ++i) {
    expected += (h(0, i) - h(0, i - 1)) - (h(i, i) - h(i, i - 1));
  }
  const double forward = directed_information(x, y, kLength).value;
  EXPECT_NEAR(forward, expected, 1e-10);
  const double backward = directed_information(y, x, kLength, kMaximumLikelihood, true).value;
  EXPECT_NEAR(forward + backward, h(kLength, 0) + h(0, kLength) - h(kLength, kLength), 1e-10);
}

TEST(DirectedInformation, CopyCarriesEveryLabel) {
  Labels x;
  for (int32_t word = 0; word < 8; ++word) {
    for (int bit = 0; bit < 3; ++bit) x.push_back((word >> bit) & 1);
  }
  EXPECT_NEAR(directed_information(x, x, 3).value, 3 * std::log(2), 1e-12);
  EXPECT_NEAR(directed_information(x, x, 3, kMaximumLikelihood, true).value, 0, 1e-12);
}

TEST(DirectedInformation, CorrectedEstimatorsAreLessBiasedOnIndependentSequences) {
  std::mt19937 random(11);
  Labels x(500), y(500);
  for (int32_t& label : x) label = int32_t(random() % 4);
  for (int32_t& label : y) label = int32_t(random() % 4);
  const double plug_in = directed_information_rate(x, y, 1).value;
  const double corrected =
      directed_information_rate(x, y, 1, CountEntropyOptions::Estimator::kMillerMadow).value;
  EXPECT_GT(plug_in, 0.1);
  EXPECT_LT(std::abs(corrected), plug_in);
}

TEST(DirectedInformation, BadInputGivesAReason) {
  const Labels ten(10, 1), nine(9, 1);
  EXPECT_FALSE(directed_information({}, {}, 1).usable());
  EXPECT_FALSE(directed_information(ten, nine, 1).usable());
  EXPECT_FALSE(directed_information(ten, ten, 3).usable());
  EXPECT_FALSE(directed_information(ten, ten, 0).usable());
  EXPECT_FALSE(directed_information(ten, ten, 10).usable());
  EXPECT_FALSE(
      directed_information(ten, ten, 2, CountEntropyOptions::Estimator::kJamesStein).usable());
  EXPECT_FALSE(directed_information_rate({}, {}, 0).usable());
  EXPECT_FALSE(directed_information_rate(ten, nine, 1).usable());
  EXPECT_FALSE(directed_information_rate(ten, ten, 9).usable());
  EXPECT_FALSE(directed_information_rate(ten, ten, -1).usable());
  EXPECT_FALSE(directed_information_rate(ten, ten, 17).usable());
  EXPECT_FALSE(
      directed_information_rate(ten, ten, 1, CountEntropyOptions::Estimator::kJamesStein).usable());
}

TEST(DirectedInformation, ConstantSequencesCarryNone) {
  const Labels constant(50, 4);
  const Estimate rate = directed_information_rate(constant, constant, 2);
  EXPECT_TRUE(rate.usable());
  EXPECT_EQ(rate.value, 0);
}

}  // namespace
}  // namespace infuse::dependence
