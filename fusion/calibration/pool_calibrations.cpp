#include "fusion/calibration/pool_calibrations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "fusion/calibration/distributions.hpp"

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr int kMaxPoolingSteps = 50;         // bounds time
constexpr double kPoolingTolerance = 1e-12;  // rad and m, of a step, near double precision

/// The calibration's deviation from a pose: T_camera_lidar = exp(deviation) T.
Vector6 deviation(const DatedCalibration& calibration, const Eigen::Isometry3d& T) {
  return geometry::log(calibration.T_camera_lidar * T.inverse());
}

/// Cholesky factors of the covariances.
std::vector<Eigen::LLT<Matrix6>> factors_of(std::span<const DatedCalibration> calibrations) {
  std::vector<Eigen::LLT<Matrix6>> factors;
  for (const DatedCalibration& calibration : calibrations) {
    factors.emplace_back(calibration.covariance);
  }
  return factors;
}

/// Gauss-Newton over the pose before (6 columns) and, with `D` = 12, the change. Barfoot's rules of
/// perturbation: T exp(ξ) and exp(ξ + d) by adjoint and Jacobians.
template <int D>
struct Pooling {
  using Vector = Eigen::Matrix<double, D, 1>;
  using Matrix = Eigen::Matrix<double, D, D>;

  std::span<const DatedCalibration> calibrations;
  std::span<const double> shares;  // of the change; with D = 6 unused
  std::vector<Eigen::LLT<Matrix6>> factors = factors_of(calibrations);
  Eigen::Isometry3d T_before = Eigen::Isometry3d::Identity();
  Vector6 change = Vector6::Zero();
  double chi_squared = 0;
  Matrix information = Matrix::Zero();

  /// One step; its length, or nothing where the parameters are not determined.
  std::optional<double> step() {
    information.setZero();
    chi_squared = 0;
    Vector gradient = Vector::Zero();
    for (size_t i = 0; i < calibrations.size(); ++i) {
      const Vector6 moved = D == 12 ? Vector6(shares[i] * change) : Vector6::Zero();
      const Eigen::Isometry3d moved_by = geometry::exp(moved);
      const Vector6 residual = deviation(calibrations[i], moved_by * T_before);
      const Matrix6 by_pose = geometry::left_jacobian_inverse(-residual);
      Eigen::Matrix<double, 6, D> jacobian;
      jacobian.template leftCols<6>() = by_pose * geometry::adjoint(moved_by);
      if constexpr (D == 12) {
        jacobian.template rightCols<6>() = shares[i] * by_pose * geometry::left_jacobian(moved);
      }
      const Eigen::Matrix<double, 6, D> weighted = factors[i].matrixL().solve(jacobian);
      const Vector6 scaled = factors[i].matrixL().solve(residual);
      information += weighted.transpose() * weighted;
      gradient += weighted.transpose() * scaled;
      chi_squared += scaled.squaredNorm();
    }
    const Eigen::LLT<Matrix> factor(information);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const Vector by = factor.solve(gradient);
    if (!by.allFinite()) return std::nullopt;
    T_before = geometry::exp(by.template head<6>()) * T_before;
    if constexpr (D == 12) change += by.template tail<6>();
    return by.norm();
  }

  bool converge() {
    for (int k = 0; k < kMaxPoolingSteps; ++k) {
      const auto length = step();
      if (!length) return false;
      if (*length < kPoolingTolerance) return true;
    }
    return false;
  }

  Matrix covariance() const { return information.llt().solve(Matrix::Identity()); }
};

constexpr const char* kNotPooled = "the calibrations differ too much to be combined";

}  // namespace

PooledPose pool_calibrations(std::span<const DatedCalibration> calibrations,
                             const Eigen::Isometry3d& T_reference) {
  PooledPose pooled{.T_camera_lidar = T_reference, .reason = "no calibration is usable"};
  if (calibrations.empty()) return pooled;
  Pooling<6> pooling{.calibrations = calibrations, .T_before = T_reference};
  pooled.reason = pooling.converge() ? "" : kNotPooled;
  if (!pooled.usable()) return pooled;
  pooled.T_camera_lidar = pooling.T_before;
  pooled.covariance = pooling.covariance();
  pooled.chi_squared = pooling.chi_squared;
  pooled.degrees_of_freedom = 6 * (static_cast<int>(calibrations.size()) - 1);
  pooled.p_value = chi_squared_exceeded(pooled.chi_squared, pooled.degrees_of_freedom);
  return pooled;
}

ChangedPose pool_changed(std::span<const DatedCalibration> calibrations,
                         std::span<const double> shares, const Eigen::Isometry3d& T_reference) {
  ChangedPose changed{.T_before = T_reference, .reason = "the shares are all alike"};
  const auto [least, most] = std::minmax_element(shares.begin(), shares.end());
  if (least == shares.end() || *most - *least < 1e-9) return changed;
  Pooling<12> pooling{.calibrations = calibrations, .shares = shares, .T_before = T_reference};
  changed.reason = pooling.converge() ? "" : kNotPooled;
  if (!changed.usable()) return changed;
  changed.T_before = pooling.T_before;
  changed.change = pooling.change;
  changed.covariance = pooling.covariance();
  changed.chi_squared = pooling.chi_squared;
  changed.degrees_of_freedom = 6 * (static_cast<int>(calibrations.size()) - 2);
  return changed;
}

bool is_covariance(const Matrix6& covariance) {
  if (!covariance.allFinite()) return false;
  const double largest = covariance.diagonal().maxCoeff();
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > 1e-9 * std::abs(largest)) {
    return false;
  }
  // Correlations instead of covariances: squares of radians and of metres differ in size.
  if (!(covariance.diagonal().minCoeff() > 0)) return false;
  const Vector6 scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6 correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::LLT<Matrix6> factor(correlation);
  return factor.info() == Eigen::Success && factor.matrixLLT().diagonal().minCoeff() > 1e-6;
}

}  // namespace infuse::calibration
