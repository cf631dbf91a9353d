#include "fusion/features/ranks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "fusion/features/discontinuity.hpp"

namespace infuse::features {
namespace {

using testing::ElementsAre;

TEST(Equalize, MatchesABruteForceCount) {
  std::mt19937_64 random(3);
  std::vector<float> values;
  for (int i = 0; i < 500; ++i) {
    values.push_back(static_cast<float>(static_cast<int>(random() % 90)) * 0.37F - 12.0F);
  }
  values.push_back(-0.0F);
  values.push_back(0.0F);
  std::vector<float> ranks = values;
  equalize(ranks);
  for (size_t i = 0; i < values.size(); ++i) {
    const auto below =
        std::count_if(values.begin(), values.end(), [&](float v) { return v < values[i]; });
    const auto equal = std::count(values.begin(), values.end(), values[i]);
    const double rank = (static_cast<double>(below) + 0.5 * static_cast<double>(equal - 1)) /
                        static_cast<double>(values.size());
    EXPECT_NEAR(ranks[i], rank, 1e-6);
  }
}

TEST(EqualizeByLevel, RanksWholeNumbersAsEqualizeDoes) {
  std::mt19937_64 random(2);
  std::vector<float> values;
  for (int i = 0; i < 500; ++i) values.push_back(static_cast<float>(random() % 256));
  std::vector<float> ranks = values, exact = values;
  equalize_by_level(ranks, 256);
  equalize(exact);
  EXPECT_EQ(ranks, exact);
}

TEST(EqualizeByLevel, KeepsNaN) {
  std::vector<float> values{0.5F, kNotCompared, 7, 0.25F, 7};
  equalize_by_level(values, 1);
  EXPECT_THAT(values, ElementsAre(0.25F, testing::IsNan(), 0.625F, 0, 0.625F));
}

TEST(Equalize, AcceptsNoneAndOneValue) {
  std::vector<float> none;
  equalize(none);
  EXPECT_TRUE(none.empty());
  std::vector<float> one{7};
  equalize(one);
  EXPECT_THAT(one, ElementsAre(0));
}

}  // namespace
}  // namespace infuse::features
