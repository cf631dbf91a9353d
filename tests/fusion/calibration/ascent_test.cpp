#include "fusion/calibration/ascent.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

Vector6 peak() {
  Vector6 at;
  at << 0.5, -1.2, 0.3, 2.0, -0.7, 0.1;
  return at;
}

/// A hill whose axes differ by a factor of 30 and are turned against the parameters'.
double quadratic(const Vector6& d, Vector6* gradient) {
  Matrix6 A = Matrix6::Identity();
  for (int i = 0; i < 6; ++i) A(i, i) = 1 + 5 * i;
  A(0, 5) = A(5, 0) = 1.5;
  A(1, 2) = A(2, 1) = -2;
  const Vector6 off = d - peak();
  if (gradient != nullptr) *gradient = -A * off;
  return 3 - 0.5 * off.dot(A * off);
}

/// Two hills along the first axis: a small one at 0.6, a large one at 6.
double two_peaks(const Vector6& d, Vector6* gradient) {
  Vector6 low = Vector6::Zero();
  Vector6 high = Vector6::Zero();
  low(0) = 0.6;
  high(0) = 6;
  const double near = std::exp(-2 * (d - low).squaredNorm());
  const double far = 5 * std::exp(-2 * (d - high).squaredNorm());
  if (gradient != nullptr) *gradient = -4 * near * (d - low) - 4 * far * (d - high);
  return near + far;
}

TEST(Ascent, BfgsFindsTheMaximum) {
  const PoseAscentResult ascent = ascend_bfgs(quadratic, {.tolerance = 1e-6});
  EXPECT_TRUE(ascent.converged);
  EXPECT_NEAR((ascent.d - peak()).norm(), 0, 1e-4);
  EXPECT_NEAR(ascent.value, 3, 1e-8);
}

TEST(Ascent, BfgsFindsTheMaximumInTenDimensions) {
  // A ridge: the coupling of the first and the last parameter is fifty times their own curvature.
  const auto ridge = [](const Parameters<10>& d, Parameters<10>* gradient) {
    Eigen::Matrix<double, 10, 10> A = Eigen::Matrix<double, 10, 10>::Identity();
    A(0, 0) = A(9, 9) = 51;
    A(0, 9) = A(9, 0) = -50;
    const Parameters<10> off = d - Parameters<10>::LinSpaced(-1, 2);
    if (gradient != nullptr) *gradient = -A * off;
    return 7 - 0.5 * off.dot(A * off);
  };
  const AscentResult<10> ascent = ascend_bfgs_10d(ridge, {.tolerance = 1e-6});
  EXPECT_TRUE(ascent.converged);
  EXPECT_NEAR((ascent.d - Parameters<10>::LinSpaced(-1, 2)).norm(), 0, 1e-4);
  EXPECT_NEAR(ascent.value, 7, 1e-8);
}

TEST(Ascent, SimplexFindsTheMaximumWithoutGradients) {
  const auto without_gradient = [](const Vector6& d, Vector6* gradient) {
    EXPECT_EQ(gradient, nullptr);
    return quadratic(d, nullptr);
  };
  const PoseAscentResult ascent =
      ascend_simplex(without_gradient, {.max_iterations = 2000, .tolerance = 1e-5});
  EXPECT_TRUE(ascent.converged);
  EXPECT_NEAR((ascent.d - peak()).norm(), 0, 1e-3);
}

TEST(Ascent, ABoundedStepStaysAtTheNearestMaximum) {
  const PoseAscentResult ascent =
      ascend_bfgs(two_peaks, {.max_iterations = 200, .tolerance = 1e-6, .max_step = 0.5});
  EXPECT_TRUE(ascent.converged);
  EXPECT_NEAR(ascent.d(0), 0.6, 1e-3);
}

TEST(Ascent, NoStepIsLongerThanAllowed) {
  Vector6 last = Vector6::Zero();
  const auto steep = [&](const Vector6& d, Vector6* gradient) {
    EXPECT_LE((d - last).norm(), 0.25 + 1e-9);
    last = d;
    return quadratic(d, gradient);
  };
  const PoseAscentResult ascent = ascend_bfgs(steep, {.max_iterations = 3, .max_step = 0.25});
  EXPECT_FALSE(ascent.converged);
}

TEST(Ascent, ReportsThatIterationsWereUsedUp) {
  EXPECT_FALSE(ascend_bfgs(quadratic, {.max_iterations = 2}).converged);
  EXPECT_FALSE(ascend_simplex(quadratic, {.max_iterations = 2}).converged);
}

TEST(Ascent, NeverEndsBelowTheInitialValue) {
  const auto valley = [](const Vector6& d, Vector6* gradient) {
    if (gradient != nullptr) *gradient = -d + Vector6::Constant(1e-9);  // a wrong gradient
    return -d.lpNorm<1>();
  };
  for (const auto& ascend : {ascend_bfgs, ascend_simplex}) {
    EXPECT_GE(ascend(valley, {.max_iterations = 30}).value, 0.0);
  }
}

TEST(Ascent, AFlatFunctionEndsAtOnce) {
  const auto flat = [](const Vector6&, Vector6* gradient) {
    if (gradient != nullptr) gradient->setZero();
    return 2.0;
  };
  const PoseAscentResult ascent = ascend_bfgs(flat, {});
  EXPECT_TRUE(ascent.converged);
  EXPECT_EQ(ascent.d, Vector6::Zero());
}

}  // namespace
}  // namespace infuse::calibration
