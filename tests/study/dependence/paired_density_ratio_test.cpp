#include "tests/study/dependence/paired_density_ratio.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/fusion/dependence/plain_fit.hpp"
#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::study {
namespace {

using namespace dependence;
using Eigen::MatrixXd;

TEST(PairedLsmi, ReferenceValues) {
  MatrixXd x(8, 1), y(8, 1);
  x << -1.5, -1, -0.5, -0.1, 0.2, 0.6, 1.1, 1.7;
  y << -1.2, -1.1, -0.2, 0.1, 0, 0.9, 0.8, 1.9;
  const double table[][4] = {{0.5, 0.1, 0.291707306969, 0.608011950929},
                             {1.0, 0.1, 0.199743962131, 0.318735814231},
                             {1.0, 0.01, 0.401320088916, 0.460748133467}};
  for (const auto& [sigma, lambda, linear, plug_in] : table) {
    FitOptions options;
    options.sigmas = {sigma};
    options.lambdas = {lambda};
    EXPECT_NEAR(paired_lsmi(x, y, options).value, linear, 1e-12);
    options.form = SmiForm::kPlugIn;
    EXPECT_NEAR(paired_lsmi(x, y, options).value, plug_in, 1e-12);
  }
}

TEST(PairedLsmi, EqualsADenseSolve) {
  const MatrixXd x = normal_samples(25, 2, 1), y = correlated_with(x, 0.5, 2);
  FitOptions options;
  options.sigmas = {0.8};
  options.lambdas = {0.05};
  const MatrixXd k = plain_kernel(x, x, 0.8), l = plain_kernel(y, y, 0.8);
  MatrixXd h = (k * k.transpose()).cwiseProduct(l * l.transpose()) / (25.0 * 25.0);
  h.diagonal().array() += 0.05;
  const Eigen::VectorXd mean = k.cwiseProduct(l).rowwise().mean();
  EXPECT_NEAR(paired_lsmi(x, y, options).value, 0.5 * mean.dot(h.fullPivLu().solve(mean)) - 0.5,
              1e-11);
}

TEST(PairedLsmi, CrossValidatedOnTheGaussian) {
  RunningMean none, half;
  for (uint64_t trial = 0; trial < 8; ++trial) {
    const MatrixXd x = normal_samples(1000, 1, 10 + trial);
    none.add(paired_lsmi(x, normal_samples(1000, 1, 40 + trial), FitOptions()).value);
    half.add(paired_lsmi(x, correlated_with(x, 0.5, 60 + trial), FitOptions()).value);
  }
  EXPECT_NEAR(none.mean(), 0.0, 0.01);
  EXPECT_NEAR(half.mean(), 1.0 / 6, 0.02 + 2 * half.standard_error());
}

FitOptions mlmi_options(double sigma, int centres) {
  FitOptions options;
  options.sigmas = {sigma};
  options.centres = centres;
  return options;
}

TEST(Mlmi, MutualInformationOfTheGaussian) {
  const double table[][2] = {{0.0, 0.0}, {0.3, 0.047155340}, {0.5, 0.143841036}};
  for (const auto& [rho, truth] : table) {
    RunningMean found;
    for (uint64_t trial = 0; trial < 8; ++trial) {
      const MatrixXd x = normal_samples(1000, 1, 100 + trial);
      found.add(mlmi(x, correlated_with(x, rho, 200 + trial), mlmi_options(0.8, 50)).value);
    }
    EXPECT_NEAR(found.mean(), truth, 0.015 + 2 * found.standard_error()) << rho;
  }
}

TEST(Mlmi, MutualInformationOfLabels) {
  // Two labels whose samples lie far apart: ln 2. A random label: 0.
  MatrixXd x = normal_samples(400, 1, 1);
  std::vector<int32_t> side, coin;
  const MatrixXd toss = normal_samples(400, 1, 2);
  for (int i = 0; i < 400; ++i) {
    side.push_back(i % 2);
    x(i) += i % 2 == 0 ? -6 : 6;
    coin.push_back(toss(i) > 0 ? 1 : 0);
  }
  EXPECT_NEAR(mlmi(x, side, 2, mlmi_options(1.5, 50)).value, std::log(2.0), 0.02);
  EXPECT_NEAR(mlmi(x, coin, 2, mlmi_options(3.0, 50)).value, 0.0, 0.03);
}

TEST(Mlmi, IsTheMaximumOfTheConstrainedLikelihood) {
  // No mixture of the basis may exceed it by more than the tolerance; try many.
  const MatrixXd x = normal_samples(60, 1, 3), y = correlated_with(x, 0.8, 4);
  const double found = mlmi(x, y, mlmi_options(0.7, 60)).value;
  const MatrixXd k = plain_kernel(x, x, 0.7), l = plain_kernel(y, y, 0.7);
  const Eigen::VectorXd means = k.rowwise().mean().cwiseProduct(l.rowwise().mean());
  const auto likelihood = [&](const Eigen::VectorXd& alpha) {
    const double norm = alpha.dot(means);  // mean r(x_i, y_j)
    return (k.cwiseProduct(l).transpose() * alpha / norm).array().log().mean();
  };
  double best = -1e9;
  for (uint64_t trial = 0; trial < 200; ++trial) {
    best = std::max(best, likelihood(normal_samples(60, 1, 500 + trial).cwiseAbs2().cwiseAbs2()));
  }
  EXPECT_GT(found, best - 1e-4);
  EXPECT_GT(found, likelihood(means.cwiseInverse()) - 1e-4);
}

TEST(Mlmi, CrossValidationFindsAWidthOfTheGrid) {
  const MatrixXd x = normal_samples(200, 1, 5), y = correlated_with(x, 0.8, 6);
  FitOptions options;
  options.centres = 30;
  options.sigmas = {1e-3, 0.5, 30};
  EXPECT_EQ(mlmi(x, y, options).hyper_parameters, (HyperParameters{0.5, 0}));
}

TEST(PairedDensityRatios, ReportReasonForInvalidInput) {
  const MatrixXd x = normal_samples(20, 1, 7), empty(0, 1);
  MatrixXd bad = x;
  bad(3) = std::numeric_limits<double>::infinity();
  FitOptions options, invalid;
  invalid.sigmas = {0};
  for (const auto& estimator :
       {+[](const Samples&a, const Samples&b, const FitOptions&o) { return paired_lsmi(a, b, o); },
        +[](const Samples&a, const Samples&b, const FitOptions&o) { return mlmi(a, b, o); }}) {
    EXPECT_STREQ(estimator(empty, empty, options).reason, "fewer than two samples");
    EXPECT_STREQ(estimator(x, MatrixXd::Ones(20, 1), options).reason, "all samples are equal");
    EXPECT_STREQ(estimator(bad, x, options).reason, "a sample is not finite");
    EXPECT_STREQ(estimator(x, x.topRows(7), options).reason, "the two sides differ in length");
    EXPECT_STREQ(estimator(x.topRows(3), x.topRows(3), options).reason, "fewer samples than folds");
    EXPECT_STREQ(estimator(x, x, invalid).reason, "invalid options");
    FitOptions tiny;
    tiny.sigmas = {1e-50};
    tiny.lambdas = {1e-3};
    EXPECT_TRUE(std::isfinite(estimator(x, x, tiny).value));
  }
  const std::vector<int32_t> alike(20, 0);
  EXPECT_STREQ(mlmi(x, alike, 2, options).reason, "all labels are equal");
}

}  // namespace
}  // namespace infuse::study
