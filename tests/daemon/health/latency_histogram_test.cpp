#include "daemon/health/latency_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace infuse::daemon {
namespace {

TEST(LatencyHistogram, IsEmptyAtFirst) {
  const LatencyStats figures = LatencyHistogram().stats();
  EXPECT_EQ(figures.count, 0U);
  EXPECT_EQ(figures.max.count(), 0);
  EXPECT_EQ(figures.p99.count(), 0);
}

TEST(LatencyHistogram, QuantilesLieWithinASixteenthAboveTheSortedList) {
  std::mt19937_64 random(7);
  std::lognormal_distribution<double> spread(13, 3);  // 20 ns … 1 s
  std::vector<int64_t> all;
  LatencyHistogram histogram;
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(static_cast<int64_t>(spread(random)));
    histogram.add(Duration(all.back()));
  }
  std::sort(all.begin(), all.end());
  for (const double q : {0.0001, 0.01, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<size_t>(std::ceil(q * static_cast<double>(all.size()))) - 1;
    const auto exact = static_cast<double>(all[rank]);
    const auto answer = static_cast<double>(histogram.quantile(q).count());
    EXPECT_GE(answer, exact) << q;
    EXPECT_LE(answer, exact * (1 + 1.0 / 16) + 1) << q;
  }
  EXPECT_EQ(histogram.stats().max.count(), all.back());
  EXPECT_EQ(histogram.stats().count, all.size());
}

TEST(LatencyHistogram, AcceptsTheWholeRangeOfDurations) {
  LatencyHistogram histogram;
  histogram.add(Duration::max());
  histogram.add(Duration::min());
  histogram.add(Duration(-1));
  EXPECT_EQ(histogram.quantile(0.5).count(), 0);
  EXPECT_EQ(histogram.quantile(1), Duration::max());
}

TEST(LatencyHistogram, SmallLatenciesAreExact) {
  for (int64_t ns = 0; ns < 16; ++ns) {
    LatencyHistogram histogram;
    histogram.add(Duration(ns));
    histogram.add(Duration(1000));
    EXPECT_EQ(histogram.quantile(0.5).count(), ns);
  }
}

}  // namespace
}  // namespace infuse::daemon
