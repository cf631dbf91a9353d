#pragma once

#include <Eigen/Geometry>

namespace infuse::geometry {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The matrix of the cross product: skew(a) b = a × b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// The rotation by |w| radians about w.
Eigen::Matrix3d rotation_exp(const Eigen::Vector3d& w);

/// The rotation vector of R, of length at most π; the inverse of `rotation_exp`.
Eigen::Vector3d rotation_log(const Eigen::Matrix3d& R);

/// Left Jacobian J of SO(3): rotation_exp(w + d) ≈ rotation_exp(J d) rotation_exp(w).
/// Barfoot, State Estimation for Robotics (7.77).
Eigen::Matrix3d rotation_left_jacobian(const Eigen::Vector3d& w);

/// The inverse of `rotation_left_jacobian`, |w| < 2π.
Eigen::Matrix3d rotation_left_jacobian_inverse(const Eigen::Vector3d& w);

/// The rigid motion of a twist (rx, ry, rz, tx, ty, tz) held for a unit of time.
Eigen::Isometry3d exp(const Vector6& twist);

/// The twist of a rigid motion, its rotation at most π; the inverse of `exp`.
Vector6 log(const Eigen::Isometry3d& T);

/// T exp(xi) T⁻¹ = exp(adjoint(T) xi).
Matrix6 adjoint(const Eigen::Isometry3d& T);

/// Left Jacobian J of SE(3): exp(xi + d) ≈ exp(J d) exp(xi). Barfoot (7.85), in our order.
Matrix6 left_jacobian(const Vector6& twist);

/// The inverse of `left_jacobian`.
Matrix6 left_jacobian_inverse(const Vector6& twist);

/// The pose a part u of the way from A (u = 0) to B (u = 1) at constant twist; u outside 0 … 1
/// extrapolates.
Eigen::Isometry3d interpolate(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B, double u);

/// Covariance of a motion given in frame b, as seen in frame a: adjoint(T_a_b) C adjoint(T_a_b)ᵀ.
Matrix6 transform_covariance(const Eigen::Isometry3d& T_a_b, const Matrix6& covariance);

}  // namespace infuse::geometry
