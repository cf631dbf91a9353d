#include "drivers/measurement/lower_envelope.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace infuse {
namespace {

double height_sum(const std::vector<EnvelopePoint>& points, double intercept, double slope) {
  double sum = 0;
  for (const EnvelopePoint& point : points) sum += point.y - intercept - slope * point.x;
  return sum;
}

/// The highest line of this slope on or below all points.
double intercept_below(const std::vector<EnvelopePoint>& points, double slope) {
  double intercept = std::numeric_limits<double>::infinity();
  for (const EnvelopePoint& point : points) {
    intercept = std::min(intercept, point.y - slope * point.x);
  }
  return intercept;
}

/// The smallest sum of vertical distances, by brute force over all slopes that the optimum can
/// have: those of all pairs of points, and the limits.
double min_height_sum(const std::vector<EnvelopePoint>& points, double max_slope) {
  std::vector<double> slopes{-max_slope, max_slope};
  for (const EnvelopePoint& a : points) {
    for (const EnvelopePoint& b : points) {
      const double slope = (b.y - a.y) / (b.x - a.x);
      if (a.x < b.x && std::abs(slope) <= max_slope) slopes.push_back(slope);
    }
  }
  double min_sum = std::numeric_limits<double>::infinity();
  for (const double slope : slopes) {
    min_sum = std::min(min_sum, height_sum(points, intercept_below(points, slope), slope));
  }
  return min_sum;
}

TEST(LowerEnvelope, IsTheClosestOfAllLinesBelowThePoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> step(0.1, 2.0);
  std::exponential_distribution<double> delay(1.0);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<EnvelopePoint> points;
    double x = -30;
    for (int i = 0; i <= trial % 64; ++i) {
      x += step(random);
      points.push_back({x, 0.3 * x + delay(random)});
    }
    const double max_slope = trial % 3 == 0 ? 0.2 : 5.0;
    std::vector<EnvelopePoint> scratch = points;
    const EnvelopeLine line = lower_envelope(scratch, max_slope);
    ASSERT_LE(std::abs(line.slope), max_slope);
    for (const EnvelopePoint& point : points) {
      ASSERT_GE(point.y - line.intercept - line.slope * point.x, -1e-9);
    }
    ASSERT_NEAR(height_sum(points, line.intercept, line.slope), min_height_sum(points, max_slope),
                1e-7);
  }
}

TEST(LowerEnvelope, FindsTheLineOfPointsOnALine) {
  std::vector<EnvelopePoint> points;
  for (int i = 0; i < 10; ++i) points.push_back({1.0 * i, 2.0 - 0.5 * i});
  const EnvelopeLine line = lower_envelope(points, 1.0);
  EXPECT_NEAR(line.intercept, 2.0, 1e-12);
  EXPECT_NEAR(line.slope, -0.5, 1e-12);
}

TEST(LowerEnvelope, IsHorizontalForOnePoint) {
  std::vector<EnvelopePoint> points{{3.0, 7.0}};
  const EnvelopeLine line = lower_envelope(points, 1.0);
  EXPECT_EQ(line.slope, 0);
  EXPECT_EQ(line.intercept, 7.0);
}

}  // namespace
}  // namespace infuse
