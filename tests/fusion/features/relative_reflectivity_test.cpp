#include "fusion/features/relative_reflectivity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace infuse::features {
namespace {

struct Returns {
  std::vector<uint16_t> ring;
  std::vector<float> range, reflectivity;

  std::vector<float> relative() const {
    return RelativeReflectivity().compute(ring, range, reflectivity);
  }
};

/// Counts quarters of octaves: 4 … 5, 5 … 6, 6 … 7, 7 … 8, 8 … 10 m and so on.
int quarter(float range) {
  const int octave = static_cast<int>(std::floor(std::log2(range)));
  return 4 * octave + static_cast<int>(4 * (range / std::exp2(octave) - 1));
}

/// Two beams, 2 to 80 m, surfaces of every kind.
Returns random_returns() {
  std::mt19937_64 random(1);
  Returns out;
  for (int i = 0; i < 4000; ++i) {
    out.ring.push_back(static_cast<uint16_t>(random() % 2 * 7));
    out.range.push_back(static_cast<float>(2 + 78 * std::pow(0x1p-64 * double(random()), 2)));
    out.reflectivity.push_back(static_cast<float>(random() % 256) / 255.0F);
  }
  return out;
}

TEST(RelativeReflectivity, MatchesABruteForceCount) {
  const Returns returns = random_returns();
  const std::vector<float> relative = returns.relative();
  const auto same_group = [&](size_t a, size_t b) {
    return returns.ring[a] == returns.ring[b] &&
           quarter(returns.range[a]) == quarter(returns.range[b]);
  };
  for (size_t i = 0; i < relative.size(); i += 13) {
    double below = 0, equal = 0, all = 0;
    for (size_t k = 0; k < relative.size(); ++k) {
      if (!same_group(i, k)) continue;
      all += 1;
      below += returns.reflectivity[k] < returns.reflectivity[i] ? 1 : 0;
      equal += returns.reflectivity[k] == returns.reflectivity[i] ? 1 : 0;
    }
    EXPECT_NEAR(relative[i], (below + equal / 2) / all, 1e-5) << i;
  }
}

TEST(RelativeReflectivity, ABeamsGainAndAMonotoneResponseChangeNothing) {
  Returns returns = random_returns();
  for (float& value : returns.reflectivity) value = std::round(value * 20) / 25.5F;
  const std::vector<float> before = returns.relative();
  for (size_t i = 0; i < returns.ring.size(); ++i) {
    float& value = returns.reflectivity[i];
    value = returns.ring[i] == 0 ? std::sqrt(value) : 0.1F + 0.5F * value;
  }
  EXPECT_EQ(returns.relative(), before);
}

TEST(RelativeReflectivity, EqualReturnsGetTheMiddleRank) {
  const Returns same{.ring = {3, 3, 3}, .range = {9, 9.1F, 9.2F}, .reflectivity = {1, 1, 1}};
  EXPECT_THAT(same.relative(), testing::Each(0.5F));
  EXPECT_TRUE(Returns{}.relative().empty());
}

TEST(RelativeReflectivity, MemoryOfTheLastSweepChangesNothing) {
  RelativeReflectivity reused;
  const Returns returns = random_returns();
  reused.compute(returns.ring, returns.range, returns.reflectivity);
  const Returns same{.ring = {3, 3}, .range = {9, 9}, .reflectivity = {0.2F, 0.4F}};
  EXPECT_THAT(reused.compute(same.ring, same.range, same.reflectivity),
              testing::ElementsAre(0.25F, 0.75F));
}

TEST(RelativeReflectivity, NonFiniteValuesAreHarmless) {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Returns odd{.ring = {65535, 0, 0, 0, 0},
                    .range = {inf, -5, nan, 0.5F, 1e30F},
                    .reflectivity = {nan, inf, -inf, nan, -3}};
  for (const float value : odd.relative()) EXPECT_TRUE(value > 0 && value < 1) << value;
}

}  // namespace
}  // namespace infuse::features
