#include "fusion/dependence/spline_tile.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/fusion/dependence/spline_oracle.hpp"

namespace infuse::dependence {
namespace {

TEST(SplineKernels, WeightsAreTheCubicSpline) {
  for (int i = 0; i <= 100; ++i) {
    const float f = 0.01F * static_cast<float>(i);
    const Float4 weights = spline_weights(f);
    for (int k = 0; k < 4; ++k) {
      EXPECT_NEAR(double(weights[k]), cubic_spline(double(f) - (k - 1)), 1e-7);
    }
  }
}

/// Compares one sample at a time with many: lanes and chunks must not matter.
TEST(SplineTile, SamplesAreIndependentOfChunksAndLanes) {
  std::mt19937 random(1);
  constexpr size_t kCount = 2051;  // two chunks and three samples
  std::vector<float> x(kCount), y(kCount), gradient(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    x[i] = static_cast<float>(random() >> 8) * 0x1p-24F;
    y[i] = static_cast<float>(random() >> 8) * 0x1.8p-24F - 0.25F;  // a third lie beyond the ends
  }
  y[100] = y[1500] = kAbsent;
  const JointHistogramOptions options;
  std::vector<double> table(32 * 32);
  for (double& value : table) value = static_cast<double>(random() % 100);
  SplineTile all(x, {}, options);
  all.differentiate(table, 1e-3, y, gradient);
  for (size_t i = 0; i < kCount; ++i) {
    SplineTile one({&x[i], 1}, {}, options);
    float alone = 0;
    one.differentiate(table, 1e-3, {&y[i], 1}, {&alone, 1});
    ASSERT_EQ(gradient[i], alone) << i;
  }
}

}  // namespace
}  // namespace infuse::dependence
