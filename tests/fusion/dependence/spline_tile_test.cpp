#include "fusion/dependence/spline_tile.hpp"

#include <gtest/gtest.h>

#include <cstring>
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

/// Everything a tile answers, as bytes.
std::vector<double> answers(Simd simd) {
  std::mt19937 random(1);
  std::vector<float> x(20011), y(20011), weights(20011), gradient(20011);
  for (size_t i = 0; i < x.size(); ++i) {
    x[i] = static_cast<float>(random() >> 8) * 0x1p-24F;
    y[i] = x[i] * x[i] + 0.3F * static_cast<float>(random() >> 8) * 0x1p-24F - 0.1F;
    weights[i] = static_cast<float>(random() % 5);
  }
  y[100] = kAbsent;
  JointHistogramOptions options;
  options.x.bins = 17;
  SplineTile tile(x, weights, options, simd);
  JointHistogram histogram{.bins_x = 17, .bins_y = 32, .mass = std::vector<double>(17 * 32)};
  tile.accumulate(y, histogram);
  tile.differentiate(histogram.mass, 1e-3, y, gradient);
  std::vector<double> all = histogram.mass;
  all.insert(all.end(), gradient.begin(), gradient.end());
  all.push_back(histogram.total);
  all.push_back(histogram.samples);
  return all;
}

TEST(SplineTile, EveryInstructionSetGivesTheSameBytes) {
  const std::vector<double> baseline = answers(Simd::kBaseline);
  int others = 0;
  for (const Simd simd : {Simd::kAvx2, Simd::kAvx512}) {
    if (simd > best_simd()) continue;
    ++others;
    const std::vector<double> these = answers(simd);
    EXPECT_EQ(std::memcmp(these.data(), baseline.data(), baseline.size() * sizeof(double)), 0);
  }
  if (others == 0) GTEST_SKIP() << "this processor has one instruction set only";
}

}  // namespace
}  // namespace infuse::dependence
