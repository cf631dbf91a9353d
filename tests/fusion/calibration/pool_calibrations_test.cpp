#include "fusion/calibration/pool_calibrations.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/fusion/calibration/drawn_calibrations.hpp"

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

TEST(PoolCalibrations, OfTranslationsIsTheWeightedMean) {
  // Without rotations the axes are separate: means weighted by 1/σ², and 1/Σ(1/σ²).
  const std::vector<double> at{0.10, 0.16, 0.07}, sigma{0.01, 0.03, 0.02};
  std::vector<DatedCalibration> calibrations(3);
  double weights = 0, sum = 0;
  for (size_t i = 0; i < 3; ++i) {
    calibrations[i].T_camera_lidar.translation().x() = at[i];
    calibrations[i].covariance = sigma[i] * sigma[i] * Matrix6::Identity();
    weights += 1 / (sigma[i] * sigma[i]);
    sum += at[i] / (sigma[i] * sigma[i]);
  }
  double chi_squared = 0;
  for (size_t i = 0; i < 3; ++i) {
    chi_squared += std::pow((at[i] - sum / weights) / sigma[i], 2);
  }
  const PooledPose pooled = pool_calibrations(calibrations, Eigen::Isometry3d::Identity());
  ASSERT_TRUE(pooled.usable()) << pooled.reason;
  EXPECT_NEAR(pooled.T_camera_lidar.translation().x(), sum / weights, 1e-12);
  EXPECT_NEAR(pooled.covariance(3, 3), 1 / weights, 1e-15);
  EXPECT_NEAR(pooled.chi_squared, chi_squared, 1e-9);
  EXPECT_EQ(pooled.degrees_of_freedom, 12);
}

TEST(PoolCalibrations, HasTheErrorThatItStates) {
  // Squared Mahalanobis distances are χ² of 6 degrees: mean 6, and of the residuals 6 (n − 1).
  std::mt19937_64 random(1);
  const Eigen::Isometry3d truth = drawn::mount();
  double squared = 0, chi_squared = 0;
  int significant = 0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<DatedCalibration> calibrations;
    for (int i = 0; i < 5; ++i) calibrations.push_back(drawn::calibration(random, truth, i));
    const PooledPose pooled = pool_calibrations(calibrations, truth);
    ASSERT_TRUE(pooled.usable());
    const Vector6 error = geometry::log(pooled.T_camera_lidar * truth.inverse());
    squared += error.dot(pooled.covariance.llt().solve(error));
    chi_squared += pooled.chi_squared;
    significant += pooled.p_value < 0.1;
  }
  EXPECT_NEAR(squared / kTrials, 6, 0.6);
  EXPECT_NEAR(chi_squared / kTrials, 24, 1.2);
  EXPECT_NEAR(significant, 0.1 * kTrials, 20);
}

TEST(PoolCalibrations, DoesNotDependOnTheReference) {
  std::mt19937_64 random(2);
  std::vector<DatedCalibration> calibrations;
  for (int i = 0; i < 4; ++i) {
    calibrations.push_back(drawn::calibration(random, drawn::mount(), i));
  }
  const PooledPose near = pool_calibrations(calibrations, drawn::mount());
  const PooledPose far = pool_calibrations(calibrations, Eigen::Isometry3d::Identity());
  ASSERT_TRUE(near.usable() && far.usable());
  EXPECT_LT((near.T_camera_lidar.matrix() - far.T_camera_lidar.matrix()).norm(), 1e-9);
}

TEST(PoolCalibrations, IsTheMinimumOfChiSquared) {
  std::mt19937_64 random(3);
  std::vector<DatedCalibration> calibrations;
  for (int i = 0; i < 4; ++i) {
    calibrations.push_back(drawn::calibration(random, drawn::mount(), i, 40));  // large deviations
  }
  const PooledPose pooled = pool_calibrations(calibrations, drawn::mount());
  ASSERT_TRUE(pooled.usable());
  const auto chi_squared = [&](const Eigen::Isometry3d& T) {
    double sum = 0;
    for (const auto& c : calibrations) {
      const Vector6 by = geometry::log(c.T_camera_lidar * T.inverse());
      sum += by.dot(c.covariance.inverse() * by);
    }
    return sum;
  };
  const double least = chi_squared(pooled.T_camera_lidar);
  EXPECT_NEAR(pooled.chi_squared, least, 1e-6 * least);
  for (int k = 0; k < 12; ++k) {
    const Vector6 aside = (k % 2 == 0 ? 1e-4 : -1e-4) * Vector6::Unit(k / 2);
    EXPECT_GT(chi_squared(geometry::exp(aside) * pooled.T_camera_lidar), least);
  }
}

TEST(PoolChanged, FindsTheChangeWithinItsSigma) {
  std::mt19937_64 random(4);
  Vector6 change;
  change << 0.002, 0.008, -0.001, 0.01, 0, -0.02;
  const std::vector<double> shares{0, 0, 0.25, 0.5, 1};
  double squared = 0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<DatedCalibration> calibrations;
    for (const double share : shares) {
      calibrations.push_back(
          drawn::calibration(random, geometry::exp(share * change) * drawn::mount(), share));
    }
    const ChangedPose fit = pool_changed(calibrations, shares, drawn::mount());
    ASSERT_TRUE(fit.usable()) << fit.reason;
    const Vector6 error = fit.change - change;
    squared += error.dot(Matrix6(fit.covariance.bottomRightCorner<6, 6>()).llt().solve(error));
  }
  EXPECT_NEAR(squared / kTrials, 6, 0.6);
}

TEST(PoolChanged, NeedsSharesThatDiffer) {
  std::mt19937_64 random(5);
  const std::vector<DatedCalibration> two{drawn::calibration(random, drawn::mount(), 0),
                                          drawn::calibration(random, drawn::mount(), 1)};
  const std::vector<double> alike{1, 1};
  EXPECT_FALSE(pool_changed(two, alike, drawn::mount()).usable());
  EXPECT_FALSE(pool_changed({}, {}, drawn::mount()).usable());
  EXPECT_FALSE(pool_calibrations({}, drawn::mount()).usable());
}

TEST(IsCovariance, RefusesWhatIsNone) {
  std::mt19937_64 random(6);
  const Matrix6 good = drawn::covariance(random);
  EXPECT_TRUE(is_covariance(good));
  EXPECT_FALSE(is_covariance(-good));
  EXPECT_FALSE(is_covariance(Matrix6::Zero()));
  Matrix6 singular = good;
  singular.row(2) = singular.row(1);
  singular.col(2) = singular.col(1);
  EXPECT_FALSE(is_covariance(singular));
  Matrix6 skew = good;
  skew(0, 1) += 1e-6;
  EXPECT_FALSE(is_covariance(skew));
  Matrix6 unknown = good;
  unknown(5, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_covariance(unknown));
}

}  // namespace
}  // namespace infuse::calibration
