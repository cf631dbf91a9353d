#include "fusion/dependence/prepared_histogram.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "tests/fusion/dependence/spline_oracle.hpp"

namespace infuse::dependence {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

/// Correlated samples, a few of them outside 0 … 1.
struct Pairs {
  std::vector<float> x, y;
  explicit Pairs(size_t n, unsigned seed = 1) : x(n), y(n) {
    std::mt19937 random(seed);
    std::normal_distribution<float> draw;
    for (size_t i = 0; i < n; ++i) {
      x[i] = 0.5F + 0.25F * draw(random);
      y[i] = 0.5F + 0.8F * (x[i] - 0.5F) + 0.15F * draw(random);
    }
  }
};

JointHistogramOptions options(int bins_x, int bins_y, Window window = Window::kBSpline) {
  return {.x = {.bins = bins_x, .low = 0, .high = 1},
          .y = {.bins = bins_y, .low = 0, .high = 1},
          .window = window};
}

TEST(PreparedHistogram, BSplineTableEqualsTheDefinition) {
  const Pairs pairs(2500);
  std::vector<float> weights(2500);
  for (size_t i = 0; i < weights.size(); ++i) weights[i] = 0.1F * static_cast<float>(i % 7);
  for (const auto& o : {options(32, 32), options(4, 4), options(5, 17)}) {
    for (const auto& w : {std::vector<float>{}, weights}) {
      PreparedHistogram prepared(pairs.x, o, w);
      const JointHistogram& table = prepared.histogram(pairs.y);
      ASSERT_TRUE(table.usable()) << table.reason;
      const JointHistogram truth = spline_oracle(pairs.x, pairs.y, o, w);
      EXPECT_THAT(table.mass, testing::Pointwise(testing::DoubleNear(1e-3), truth.mass));
      EXPECT_NEAR(table.total, truth.total, 1e-3);
      EXPECT_EQ(table.samples, 2500);
    }
  }
}

TEST(PreparedHistogram, ManySamplesInOneCellKeepTheirSum) {
  std::vector<float> x(300000, 0.37F), y(300000, 0.61F);
  x[0] = 0.1F;
  y[0] = 0.9F;
  PreparedHistogram prepared(x, options(32, 32));
  EXPECT_NEAR(prepared.histogram(y).total, 300000, 30);
}

TEST(PreparedHistogram, WithoutWindowCountsEqualParts) {
  const std::vector<float> x = {0.0F, 0.24F, 0.26F, 1.0F, 7.0F, -3.0F};
  const std::vector<float> y = {0.0F, 0.6F, 0.4F, 1.0F, 0.4F, 0.6F};
  const JointHistogram table = joint_histogram(x, y, options(4, 2, Window::kNone));
  EXPECT_THAT(table.mass, testing::ElementsAre(1, 2, 1, 0, 0, 0, 1, 1));
  const std::vector<float> weights = {1, 2, 4, 8, 16, 32};
  const JointHistogram weighted = joint_histogram(x, y, options(4, 2, Window::kNone), weights);
  EXPECT_THAT(weighted.mass, testing::ElementsAre(1, 34, 4, 0, 0, 0, 16, 8));
}

// A single count far from the edges becomes a Gaussian of Silverman's width. Another count sets the
// standard deviation of the marginals: two equal counts at a distance 2a have the standard
// deviation a.
TEST(PreparedHistogram, GaussianWindowHasSilvermansBandwidth) {
  const int bins = 101;
  std::vector<double> mass(static_cast<size_t>(bins * bins));
  mass[static_cast<size_t>(40 * bins + 45)] = 5000;
  mass[static_cast<size_t>(60 * bins + 55)] = 5000;
  JointHistogram table = joint_table(mass, bins, bins);
  std::vector<double> scratch;
  smooth_gaussian(table, scratch);
  const double factor = 1.06 * std::pow(10000.0, -0.2);
  const auto kernel = [](double d, double s) {
    return std::exp(-d * d / (2 * s * s)) / (s * std::sqrt(2 * 3.14159265358979));
  };
  for (int x = 35; x <= 45; ++x) {
    for (int y = 42; y <= 48; ++y) {
      const double expected = 5000 * kernel(x - 40, factor * 10) * kernel(y - 45, factor * 5);
      EXPECT_NEAR(table.at(x, y), expected, 1e-3 * 5000 * 0.1) << x << " " << y;
    }
  }
}

TEST(PreparedHistogram, GaussianWindowKeepsTheMassAndLowersTheInformation) {
  const Pairs pairs(500);
  const JointHistogram plain = joint_histogram(pairs.x, pairs.y, options(32, 32, Window::kNone));
  const JointHistogram smooth =
      joint_histogram(pairs.x, pairs.y, options(32, 32, Window::kGaussian));
  double sum = 0;
  for (const double m : smooth.mass) sum += m;
  EXPECT_NEAR(sum, plain.total, 1e-9);
  EXPECT_LT(measure(Measure::kMutualInformation, smooth).value,
            measure(Measure::kMutualInformation, plain).value);
}

TEST(PreparedHistogram, ValuesAgreeWithTheOracle) {
  const Pairs pairs(3000);
  PreparedHistogram prepared(pairs.x, options(24, 32));
  const JointHistogram truth = spline_oracle(pairs.x, pairs.y, options(24, 32));
  for (const MeasureName& each : kMeasureNames) {
    const Measure which = each.measure;
    EXPECT_NEAR(prepared.value(which, pairs.y).value, measure(which, truth).value, 2e-6);
  }
}

TEST(PreparedHistogram, GradientAgreesWithCentralDifferencesOfTheOracle) {
  const Pairs pairs(400);
  std::vector<float> weights(400);
  for (size_t i = 0; i < weights.size(); ++i)
    weights[i] = 0.5F + 0.01F * static_cast<float>(i % 50);
  JointHistogramOptions o = options(10, 12);
  o.y.low = -0.5;  // a scale other than 1
  o.y.high = 1.25;
  const std::vector<double> x(pairs.x.begin(), pairs.x.end());
  std::vector<double> y(pairs.y.begin(), pairs.y.end());
  std::vector<float> gradient(400);
  PreparedHistogram prepared(pairs.x, o, weights);
  for (const MeasureName& each : kMeasureNames) {
    const Measure which = each.measure;
    ASSERT_TRUE(prepared.value_and_gradient(which, pairs.y, gradient).usable());
    double largest = 0;
    for (const float g : gradient) largest = std::max(largest, std::abs(double(g)));
    ASSERT_GT(largest, 1e-6);
    for (size_t i = 0; i < 400; i += 7) {
      const double saved = y[i], step = 1e-4;
      y[i] = saved + step;
      const double above = measure(which, spline_oracle(x, y, o, weights)).value;
      y[i] = saved - step;
      const double below = measure(which, spline_oracle(x, y, o, weights)).value;
      y[i] = saved;
      EXPECT_NEAR(double(gradient[i]), (above - below) / (2 * step), 2e-4 * largest) << i;
    }
  }
}

TEST(PreparedHistogram, GradientIsZeroOutsideTheAxisAndWhereAbsent) {
  Pairs pairs(1000);
  pairs.y[3] = -0.2F;
  pairs.y[4] = 1.3F;
  pairs.y[5] = kAbsent;
  std::vector<float> gradient(1000);
  PreparedHistogram prepared(pairs.x, options(32, 32));
  ASSERT_TRUE(prepared.value_and_gradient(Measure::kMutualInformation, pairs.y, gradient).usable());
  EXPECT_EQ(gradient[3], 0);
  EXPECT_EQ(gradient[4], 0);
  EXPECT_EQ(gradient[5], 0);
  EXPECT_NE(gradient[6], 0);
}

TEST(PreparedHistogram, AbsentSamplesAreIgnored) {
  Pairs pairs(1000), some(0);
  for (size_t i = 0; i < 1000; ++i) {
    if (i % 3 == 0) {
      pairs.y[i] = kAbsent;
    } else {
      some.x.push_back(pairs.x[i]);
      some.y.push_back(pairs.y[i]);
    }
  }
  for (const Window window : {Window::kNone, Window::kGaussian, Window::kBSpline}) {
    const JointHistogram table = joint_histogram(pairs.x, pairs.y, options(8, 8, window));
    EXPECT_EQ(table.samples, double(some.x.size()));
    EXPECT_EQ(table.mass, joint_histogram(some.x, some.y, options(8, 8, window)).mass);
  }
}

TEST(PreparedHistogram, SymmetricInItsSides) {
  const Pairs pairs(2000);
  for (const Window window : {Window::kNone, Window::kGaussian, Window::kBSpline}) {
    for (const MeasureName& each : kMeasureNames) {
      const Measure which = each.measure;
      const double xy =
          measure(which, joint_histogram(pairs.x, pairs.y, options(12, 20, window))).value;
      const double yx =
          measure(which, joint_histogram(pairs.y, pairs.x, options(20, 12, window))).value;
      EXPECT_NEAR(xy, yx, 1e-6);
      EXPECT_GE(xy, 0);
    }
  }
}

TEST(PreparedHistogram, RepeatedEvaluationGivesTheSameBytes) {
  const Pairs pairs(5000), other(5000, 2);
  PreparedHistogram prepared(pairs.x, options(32, 32));
  std::vector<float> first(5000), second(5000);
  const double value =
      prepared.value_and_gradient(Measure::kMutualInformation, pairs.y, first).value;
  prepared.value_and_gradient(Measure::kChiSquared, other.y, second);
  EXPECT_EQ(prepared.value_and_gradient(Measure::kMutualInformation, pairs.y, second).value, value);
  EXPECT_EQ(first, second);
}

/// For every window and measure: a reason, a finite value, no NaN in the gradient.
void expect_reason(const std::vector<float>& x, const std::vector<float>& y,
                   const std::string& reason, const std::vector<float>& weights = {}) {
  for (const Window window : {Window::kNone, Window::kGaussian, Window::kBSpline}) {
    PreparedHistogram prepared(x, options(8, 8, window), weights);
    for (const MeasureName& each : kMeasureNames) {
      const Measure which = each.measure;
      const Estimate estimate = prepared.value(which, y);
      EXPECT_THAT(std::string(estimate.reason), testing::HasSubstr(reason));
      EXPECT_TRUE(std::isfinite(estimate.value));
      std::vector<float> gradient(x.size(), 1.0F);
      EXPECT_FALSE(prepared.value_and_gradient(which, y, gradient).usable());
      for (const float g : gradient) EXPECT_TRUE(std::isfinite(g));
    }
  }
}

TEST(PreparedHistogram, BadInputGivesAReason) {
  const Pairs good(100);
  expect_reason({}, {}, "no samples");
  expect_reason(good.x, {}, "the sides differ in size");
  expect_reason(good.x, std::vector<float>(100, 0.3F), "constant");
  expect_reason(std::vector<float>(100, 0.3F), good.y, "constant");
  expect_reason(good.x, std::vector<float>(100, 5.0F), "constant");  // all beyond the axis
  expect_reason(good.x, std::vector<float>(100, kAbsent), "no valid samples");
  expect_reason(good.x, good.y, "no valid samples", std::vector<float>(100, 0.0F));
  expect_reason(good.x, good.y, "weight", std::vector<float>(100, kNotANumber));
  expect_reason(good.x, good.y, "weight", std::vector<float>(3, 1.0F));
  expect_reason({0.1F, 0.5F, 0.9F}, {0.2F, 0.3F, 0.8F}, "fewer samples than bins");
  std::vector<float> spoiled = good.x;
  spoiled[50] = kNotANumber;
  expect_reason(spoiled, good.y, "not finite");
  expect_reason(good.x, spoiled, "not a number");
  spoiled[50] = -kAbsent;
  expect_reason(good.x, spoiled, "not a number");
}

TEST(PreparedHistogram, HugeValuesAndAxesStayFinite) {
  Pairs pairs(200);
  pairs.y[7] = std::numeric_limits<float>::max();
  pairs.y[8] = -std::numeric_limits<float>::max();
  for (const Window window : {Window::kNone, Window::kGaussian, Window::kBSpline}) {
    for (const double high : {1e-29, 1.0, 1e29}) {
      JointHistogramOptions o = options(8, 8, window);
      o.y.high = high;
      PreparedHistogram prepared(pairs.x, o);
      std::vector<float> gradient(200);
      EXPECT_TRUE(std::isfinite(prepared.value(Measure::kMutualInformation, pairs.y).value));
      prepared.value_and_gradient(Measure::kMutualInformation, pairs.y, gradient);
      for (const float g : gradient) EXPECT_FALSE(std::isnan(g));
    }
  }
}

TEST(PreparedHistogram, InvalidOptionsAreReported) {
  EXPECT_FALSE(options(32, 32).invalid());
  EXPECT_TRUE(options(3, 32).invalid());
  EXPECT_FALSE(options(3, 32, Window::kNone).invalid());
  EXPECT_TRUE(options(0, 32, Window::kNone).invalid());
  EXPECT_TRUE(options(32, 5000).invalid());
  JointHistogramOptions o;
  o.x.high = o.x.low;
  EXPECT_TRUE(o.invalid());
  o.x.high = std::nan("");
  EXPECT_TRUE(o.invalid());
  const Pairs pairs(10);
  EXPECT_FALSE(PreparedHistogram(pairs.x, o).value(Measure::kMutualInformation, pairs.y).usable());
}

}  // namespace
}  // namespace infuse::dependence
