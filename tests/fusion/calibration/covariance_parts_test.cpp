#include "fusion/calibration/covariance_parts.hpp"

#include <gtest/gtest.h>

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

/// Variances of all axes, and of ry.
Matrix6 of_diagonal(double all, double ry) {
  Vector6 diagonal = Vector6::Constant(all);
  diagonal(1) = ry;
  return diagonal.asDiagonal();
}

TEST(CovarianceParts, AddUpAndNameTheLargest) {
  CalibrationResult result;
  result.uncertainty.bias_covariance = of_diagonal(1, 4);
  result.uncertainty.covariance = result.uncertainty.bias_covariance + of_diagonal(2, 1);
  ParameterCheck focal{.parameter = "focal length"};
  focal.pose_sensitivity = 2 * Vector6::Unit(5);
  focal.known_sigma = 3;
  focal.unseen_sigma = 4;  // together 5: a variance of 100
  result.parameter_checks = {focal};
  result.model_covariance =
      model_covariance(result.parameter_checks, result.uncertainty.covariance);
  const auto parts = covariance_parts(result);
  Matrix6 sum = Matrix6::Zero();
  for (const CovariancePart& part : parts) sum += part.covariance;
  EXPECT_TRUE(sum.isApprox(result.covariance()));
  const auto largest = largest_parts(parts);
  EXPECT_EQ(largest[0].name, "the scatter of the scenes");
  EXPECT_EQ(largest[1].name, "the bias of the measure");
  EXPECT_DOUBLE_EQ(largest[1].share, 0.8);
  EXPECT_EQ(largest[5].name, "the focal length");
  EXPECT_DOUBLE_EQ(largest[5].share, 100.0 / 103);
}

}  // namespace
}  // namespace infuse::calibration
