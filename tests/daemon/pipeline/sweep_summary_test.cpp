#include "daemon/pipeline/sweep_summary.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace infuse::daemon {
namespace {

TEST(SweepSummary, MeansAreThoseOfTheReturns) {
  Sweep sweep;
  sweep.resize(1003);
  double range_sum = 0;
  for (size_t i = 0; i < sweep.size(); ++i) {
    sweep.range[i] = static_cast<float>(i) * 0.25F;
    sweep.reflectivity[i] = 0.5F;
    range_sum += static_cast<double>(sweep.range[i]);
  }
  sweep.gaps = {{0.5, 1.0}, {-1.0, -3.0}};
  sweep.lost_packets = 4;
  const SweepReport report = summarise(sweep, "top");
  EXPECT_EQ(report.device, "top");
  EXPECT_EQ(report.returns, 1003U);
  EXPECT_DOUBLE_EQ(report.mean_range, range_sum / 1003);  // exact in double
  EXPECT_EQ(report.max_range, 250.5);
  EXPECT_EQ(report.mean_reflectivity, 0.5);
  EXPECT_EQ(report.gaps, 2U);
  EXPECT_DOUBLE_EQ(report.gap_angle, 2.5);
  EXPECT_EQ(report.lost_packets, 4U);
}

TEST(SweepSummary, AnEmptySweepHasNoMeans) {
  const SweepReport report = summarise(Sweep(), "top");
  EXPECT_EQ(report.returns, 0U);
  EXPECT_TRUE(std::isnan(report.mean_range));
  EXPECT_TRUE(std::isnan(report.max_range));
}

}  // namespace
}  // namespace infuse::daemon
