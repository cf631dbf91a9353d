#include "fusion/dependence/gaussian_kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fusion/dependence/sample_choice.hpp"
#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::dependence {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

TEST(GaussianKernel, EqualsTheExponentialOfTheDistance) {
  for (const Index centre_count : {1, 3, 7, 8, 20, 41}) {
    const MatrixXd x = normal_samples(50, 3, 1), c = normal_samples(centre_count, 3, 2);
    MatrixXd kernel;
    gaussian_kernel(x, c, 0.3, kernel);
    ASSERT_EQ(kernel.rows(), centre_count);
    ASSERT_EQ(kernel.cols(), 50);
    for (Index i = 0; i < 50; ++i) {
      for (Index l = 0; l < centre_count; ++l) {
        const double truth = std::exp(-(x.row(i) - c.row(l)).squaredNorm() / (2 * 0.3 * 0.3));
        EXPECT_NEAR(kernel(l, i), truth, 1e-13 * truth);
      }
    }
  }
}

TEST(GaussianKernel, ExponentialIsExactOverItsWholeRange) {
  // At σ² = ½ the argument is −d² exactly, so that only the exponential has an error.
  MatrixXd x(20000, 1), c = MatrixXd::Zero(1, 1), kernel;
  for (Index i = 0; i < x.rows(); ++i) x(i) = std::sqrt(706.0 * static_cast<double>(i) / 20000);
  gaussian_kernel(x, c, std::sqrt(0.5), kernel);
  const double factor = -0.5 / (std::sqrt(0.5) * std::sqrt(0.5));
  for (Index i = 0; i < x.rows(); ++i) {
    const double truth = std::exp(x(i) * x(i) * factor);
    ASSERT_NEAR(kernel(i), truth, 6e-16 * truth) << x(i);
  }
  EXPECT_EQ(kernel(0), 1.0);
}

TEST(GaussianKernel, UnderflowIsZero) {
  MatrixXd x(3, 1), kernel;
  x << 0, 1e3, 1e100;
  gaussian_kernel(x, x, 1e-50, kernel);
  EXPECT_EQ(kernel, MatrixXd::Identity(3, 3));
}

TEST(GaussianKernel, SameBytesOnEveryInstructionSet) {
  const MatrixXd x = normal_samples(101, 6, 3), c = normal_samples(43, 6, 4);
  MatrixXd baseline, other;
  gaussian_kernel(x, c, 0.7, baseline, InstructionSet::kBaseline);
  for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!supported(set)) continue;
    gaussian_kernel(x, c, 0.7, other, set);
    EXPECT_EQ(other, baseline);
  }
}

TEST(GaussianKernel, OverlapIsTheIntegralOfTheProduct) {
  const MatrixXd c = normal_samples(4, 1, 5);
  constexpr double kSigma = 0.6, kStep = 1e-3;
  MatrixXd overlap;
  gaussian_overlap(c, kSigma, overlap);
  for (Index l = 0; l < 4; ++l) {
    for (Index m = 0; m < 4; ++m) {
      double integral = 0;
      for (double x = -10; x < 10; x += kStep) {
        const double a = x - c(l), b = x - c(m);
        integral += std::exp(-(a * a + b * b) / (2 * kSigma * kSigma)) * kStep;
      }
      EXPECT_NEAR(overlap(l, m), integral, 1e-10);
    }
  }
  // In two dimensions the integral is a product of one-dimensional integrals.
  MatrixXd flat(2, 2), flat_overlap;
  flat << c(0), c(0), c(1), c(1);
  gaussian_overlap(flat, kSigma, flat_overlap);
  EXPECT_NEAR(flat_overlap(0, 1), overlap(0, 1) * overlap(0, 1), 1e-12);
}

TEST(GaussianKernel, GradientEqualsCentralDifferences) {
  // Far from the origin, where sums over x − c cancel unless the samples are centred.
  MatrixXd x = normal_samples(30, 4, 6).array() + 1e4;
  const std::vector<int> rows = {2, 3, 5, 7, 11, 13, 17, 19, 23};
  const MatrixXd weight = normal_samples(9, 30, 7);
  const auto scalar = [&](const MatrixXd& at) {
    MatrixXd c, kernel;
    gather_rows(at, rows, c);
    gaussian_kernel(at, c, 1.5, kernel);
    return kernel.cwiseProduct(weight).sum();
  };
  MatrixXd c, kernel, sensitivity = weight, gradient;
  gather_rows(x, rows, c);
  gaussian_kernel(x, c, 1.5, kernel);
  gaussian_kernel_gradient(x, rows, 1.5, kernel, sensitivity, gradient);
  ASSERT_EQ(gradient.rows(), 30);
  ASSERT_EQ(gradient.cols(), 4);
  const MatrixXd difference = central_differences(scalar, x, 1e-4);
  EXPECT_LT((gradient - difference).cwiseAbs().maxCoeff(), 1e-6);
}

}  // namespace
}  // namespace infuse::dependence
