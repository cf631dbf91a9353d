#include "drivers/recording/rigid_matrix.hpp"

#include <Eigen/SVD>

namespace infuse::recording {

std::optional<Eigen::Isometry3d> to_rigid(const Eigen::Matrix4d& matrix) {
  constexpr double kMaxRotationError = 1e-3, kExactRotationError = 1e-12;
  if (!matrix.allFinite() || matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) return std::nullopt;
  const Eigen::Matrix3d given = matrix.topLeftCorner<3, 3>();
  const double rotation_error =
      (given * given.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(rotation_error <= kMaxRotationError) || given.determinant() < 0) return std::nullopt;

  Eigen::Isometry3d T;
  T.matrix() = matrix;
  if (rotation_error > kExactRotationError) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(given, Eigen::ComputeFullU | Eigen::ComputeFullV);
    T.linear() = svd.matrixU() * svd.matrixV().transpose();
  }
  return T;
}

std::optional<Eigen::Isometry3d> to_rigid(std::span<const double> by_row) {
  if (by_row.size() != 16) return std::nullopt;
  return to_rigid(Eigen::Matrix4d(
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(by_row.data())));
}

}  // namespace infuse::recording
