#include "fusion/dependence/shrunk_information.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::dependence {
namespace {

struct Tables {
  std::vector<double> target{0.4, 0.3, 0.15, 0.1, 0.05};
  std::vector<std::vector<double>> counts =
      std::vector<std::vector<double>>(5, std::vector<double>(5, 0.0));
  double total = 0;
};

/// Tables of labels that are often equal, in both the object and a full table.
Tables draw(int n, ShrunkInformation& information) {
  Tables pairs;
  std::mt19937 random(7);
  for (int i = 0; i < n; ++i) {
    const auto label = [&] { return static_cast<uint32_t>(random() % 5); };
    const uint32_t x = label(), y = random() % 3 == 0 ? label() : x;
    information.add(x, y);
    pairs.counts[x][y] += 1;
    pairs.total += 1;
  }
  return pairs;
}

/// Mutual information of a full table, by its definition.
double brute_force(const Tables& pairs, double lambda) {
  std::vector<std::vector<double>> p = pairs.counts;
  std::vector<double> px(5, 0.0), py(5, 0.0);
  for (size_t x = 0; x < 5; ++x) {
    for (size_t y = 0; y < 5; ++y) {
      p[x][y] = lambda * pairs.target[x] * pairs.target[y] +
                (1 - lambda) * pairs.counts[x][y] / pairs.total;
      px[x] += p[x][y];
      py[y] += p[x][y];
    }
  }
  double information = 0;
  for (size_t x = 0; x < 5; ++x) {
    for (size_t y = 0; y < 5; ++y) {
      if (p[x][y] > 0) information += p[x][y] * std::log(p[x][y] / (px[x] * py[y]));
    }
  }
  return information;
}

TEST(ShrunkInformation, EqualsTheDefinitionOnTheFullTable) {
  ShrunkInformation information(Tables().target);
  const Tables pairs = draw(23, information);
  for (const double lambda : {0.0, 0.01, 0.3, 0.9, 1.0}) {
    EXPECT_NEAR(information.value(lambda), brute_force(pairs, lambda), 1e-12) << lambda;
  }
}

TEST(ShrunkInformation, OptimalShrinkageFollowsItsFormula) {
  ShrunkInformation information(Tables().target);
  EXPECT_EQ(information.optimal_shrinkage(), 1);
  const Tables pairs = draw(23, information);
  double variance = 0, distance = 0;
  for (size_t x = 0; x < 5; ++x) {
    for (size_t y = 0; y < 5; ++y) {
      const double p = pairs.counts[x][y] / pairs.total;
      const double t = pairs.target[x] * pairs.target[y];
      variance += p * (1 - p) / (pairs.total - 1);
      distance += (p - t) * (p - t);
    }
  }
  EXPECT_NEAR(information.optimal_shrinkage(), variance / distance, 1e-12);
}

TEST(ShrunkInformation, ForgetsItsPairs) {
  ShrunkInformation information(Tables().target);
  draw(40, information);
  information.clear();
  EXPECT_EQ(information.total(), 0);
  EXPECT_EQ(information.value(0.5), 0);
  const Tables pairs = draw(11, information);
  EXPECT_NEAR(information.value(0.2), brute_force(pairs, 0.2), 1e-12);
}

}  // namespace
}  // namespace infuse::dependence
