#pragma once

#include <Eigen/Cholesky>
#include <random>
#include <vector>

#include "fusion/calibration/pool_calibrations.hpp"

namespace infuse::calibration::drawn {

inline geometry::Vector6 normal(std::mt19937_64& random) {
  std::normal_distribution<double> unit;
  geometry::Vector6 values;
  for (int k = 0; k < 6; ++k) values(k) = unit(random);
  return values;
}

/// A covariance with correlations, about 0.05° and 5 mm.
inline geometry::Matrix6 covariance(std::mt19937_64& random) {
  geometry::Matrix6 mixed;
  for (int k = 0; k < 6; ++k) mixed.col(k) = normal(random);
  const geometry::Matrix6 shape = geometry::Matrix6::Identity() + 0.1 * mixed * mixed.transpose();
  geometry::Vector6 scale;
  scale << 7e-4, 7e-4, 7e-4, 4e-3, 4e-3, 4e-3;
  return scale.asDiagonal() * shape * scale.asDiagonal();
}

/// A camera that looks ahead from beside the lidar.
inline Eigen::Isometry3d mount() {
  geometry::Vector6 twist;
  twist << 1.2, -1.21, 1.19, 0.1, -0.3, -0.5;
  return geometry::exp(twist);
}

/// A calibration of `T` whose error is drawn from its covariance, `excess` times as large.
inline DatedCalibration calibration(std::mt19937_64& random, const Eigen::Isometry3d& T,
                                    double days, double excess = 1) {
  DatedCalibration drawn{.days = days, .covariance = covariance(random)};
  geometry::Vector6 error = drawn.covariance.llt().matrixL() * normal(random);
  error *= excess;
  drawn.T_camera_lidar = geometry::exp(error) * T;
  return drawn;
}

}  // namespace infuse::calibration::drawn
