#include "tests/study/dependence/distance_correlation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::study {
namespace {

using namespace dependence;
using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd distances(const MatrixXd& x) {
  MatrixXd d(x.rows(), x.rows());
  for (Index i = 0; i < x.rows(); ++i) {
    for (Index j = 0; j < x.rows(); ++j) d(i, j) = (x.row(i) - x.row(j)).norm();
  }
  return d;
}

// Doubly centred distances (Székely et al. 2007), or U-centred (Székely and Rizzo 2014).
MatrixXd centred(const MatrixXd& d, bool unbiased) {
  const double n = static_cast<double>(d.rows());
  MatrixXd c(d.rows(), d.cols());
  for (Index i = 0; i < d.rows(); ++i) {
    for (Index j = 0; j < d.cols(); ++j) {
      c(i, j) = unbiased ? d(i, j) - d.row(i).sum() / (n - 2) - d.col(j).sum() / (n - 2) +
                               d.sum() / ((n - 1) * (n - 2))
                         : d(i, j) - d.row(i).mean() - d.col(j).mean() + d.mean();
    }
    if (unbiased) c(i, i) = 0;
  }
  return c;
}

DistanceDependence by_definition(const MatrixXd& x, const MatrixXd& y) {
  DistanceDependence truth;
  const MatrixXd a = centred(distances(x), false), b = centred(distances(y), false);
  truth.covariance = std::sqrt(a.cwiseProduct(b).mean());
  truth.correlation =
      std::sqrt(a.cwiseProduct(b).sum() / std::sqrt(a.squaredNorm() * b.squaredNorm()));
  const MatrixXd ua = centred(distances(x), true), ub = centred(distances(y), true);
  truth.corrected_correlation =
      ua.cwiseProduct(ub).sum() / std::sqrt(ua.squaredNorm() * ub.squaredNorm());
  return truth;
}

void expect_equal(const DistanceDependence& found, const DistanceDependence& truth, double near) {
  EXPECT_STREQ(found.reason, "");
  EXPECT_NEAR(found.covariance, truth.covariance, near);
  EXPECT_NEAR(found.correlation, truth.correlation, near);
  EXPECT_NEAR(found.corrected_correlation, truth.corrected_correlation, near);
}

TEST(DistanceCorrelation, ReferenceValues) {
  MatrixXd x(10, 1), z(10, 1);
  x << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10;
  z << 2, 1, 4, 3, 7, 8, 9, 5, 10, 6;
  const DistanceDependence found = distance_dependence(x, z);
  EXPECT_NEAR(found.correlation, 0.799923140796, 1e-12);
  EXPECT_NEAR(found.covariance, 1.707044229070, 1e-12);
  EXPECT_NEAR(found.corrected_correlation, 0.532467532468, 1e-12);
  const MatrixXd square = (x.array() - 5.5).square();
  EXPECT_NEAR(distance_correlation(x, square).value, 0.498856977996, 1e-12);
  EXPECT_NEAR(corrected_distance_correlation(x, z).value, 0.532467532468, 1e-12);
}

TEST(DistanceCorrelation, FastScalarsEqualTheDefinition) {
  for (const Index n : {4, 5, 17, 100, 257}) {
    const MatrixXd x = normal_samples(n, 1, 1), y = correlated_with(x, 0.4, 2);
    expect_equal(distance_dependence(x, y), by_definition(x, y), 1e-11);
  }
}

TEST(DistanceCorrelation, FastScalarsWithTiesEqualTheDefinition) {
  const MatrixXd x = (2 * normal_samples(150, 1, 3)).array().round();
  const MatrixXd y = (x + normal_samples(150, 1, 4)).array().round();
  expect_equal(distance_dependence(x, y), by_definition(x, y), 1e-11);
}

TEST(DistanceCorrelation, VectorsEqualTheDefinition) {
  const MatrixXd x = normal_samples(120, 3, 5);
  const MatrixXd y = correlated_with(x, 0.5, 6).leftCols(2);
  expect_equal(distance_dependence(x, y), by_definition(x, y), 1e-11);
  expect_equal(distance_dependence(x, y.leftCols(1)), by_definition(x, y.leftCols(1)), 1e-11);
}

TEST(DistanceCorrelation, IsSymmetricAndInvariantToShiftAndScale) {
  const MatrixXd x = normal_samples(200, 1, 7), y = correlated_with(x, 0.6, 8);
  const DistanceDependence there = distance_dependence(x, y), back = distance_dependence(y, x);
  expect_equal(there, back, 1e-12);
  const DistanceDependence moved = distance_dependence((1e3 * x).array() - 5e4, y);
  EXPECT_NEAR(moved.correlation, there.correlation, 1e-9);
  EXPECT_NEAR(moved.covariance, there.covariance * std::sqrt(1e3), 1e-7);
  EXPECT_NEAR(distance_correlation(1e90 * x, y).value, there.correlation, 1e-9);
  EXPECT_NEAR(distance_correlation(1e-90 * x, y).value, there.correlation, 1e-9);
  EXPECT_NEAR(distance_correlation(x, -3 * x).value, 1.0, 1e-12);
}

TEST(DistanceCorrelation, PopulationValuesOfTheGaussian) {
  // The bias-corrected dCor² is nearly unbiased; the tables give dCor.
  const double table[][2] = {{0.3, 0.269001114},
                             {0.5, 0.454126504},
                             {0.8, 0.754896808},
                             {0.9, 0.868178054},
                             {0.95, 0.930112866}};
  for (const auto& [rho, population] : table) {
    RunningMean found;
    for (uint64_t trial = 0; trial < 20; ++trial) {
      const MatrixXd x = normal_samples(2000, 1, 10 + trial);
      found.add(corrected_distance_correlation(x, correlated_with(x, rho, 50 + trial)).value);
    }
    EXPECT_NEAR(found.mean(), population * population, 4 * found.standard_error()) << rho;
    EXPECT_LT(found.standard_error(), 0.01);
  }
}

TEST(DistanceCorrelation, ReportsReasonForInvalidInput) {
  MatrixXd x = normal_samples(20, 1, 9);
  const MatrixXd constant = MatrixXd::Constant(20, 1, 3.0), empty(0, 1);
  EXPECT_STREQ(distance_correlation(x, constant).reason, "all samples are equal");
  EXPECT_STREQ(distance_correlation(empty, empty).reason, "fewer than two samples");
  EXPECT_STREQ(distance_correlation(x, x.topRows(5)).reason, "the two sides differ in length");
  EXPECT_STREQ(corrected_distance_correlation(x.topRows(3), x.topRows(3)).reason,
               "fewer than four samples");
  x(3) = std::numeric_limits<double>::quiet_NaN();
  const Estimate bad = distance_correlation(x, x);
  EXPECT_STREQ(bad.reason, "a sample is not finite");
  EXPECT_EQ(bad.value, 0.0);
  // Constant except for the last bit: the distances are below rounding.
  MatrixXd almost = constant;
  almost(0) = std::nextafter(3.0, 4.0);
  const Estimate nothing = distance_correlation(almost, normal_samples(20, 1, 9));
  EXPECT_TRUE(std::isfinite(nothing.value));
}

}  // namespace
}  // namespace infuse::study
