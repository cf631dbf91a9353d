#pragma once

#include <Eigen/Geometry>

namespace infuse::geometry {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Cross-product matrix: skew(a) b = a × b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// Rotation by |w| radians about w.
Eigen::Matrix3d rotation_exp(const Eigen::Vector3d& w);

/// Rotation vector of R, of length at most π; the inverse of `rotation_exp`.
Eigen::Vector3d rotation_log(const Eigen::Matrix3d& R);

/// Left Jacobian J of SO(3): rotation_exp(w + d) ≈ rotation_exp(J d) rotation_exp(w).
/// Barfoot, State Estimation for Robotics (7.77).
Eigen::Matrix3d rotation_left_jacobian(const Eigen::Vector3d& w);

/// Inverse of `rotation_left_jacobian`, |w| < 2π.
Eigen::Matrix3d rotation_left_jacobian_inverse(const Eigen::Vector3d& w);

/// Rigid motion of the twist (rx, ry, rz, tx, ty, tz) over unit time.
Eigen::Isometry3d exp(const Vector6& twist);

/// Twist of a rigid motion with a rotation of at most π; the inverse of `exp`.
Vector6 log(const Eigen::Isometry3d& T);

/// Adjoint: T exp(xi) T⁻¹ = exp(adjoint(T) xi).
Matrix6 adjoint(const Eigen::Isometry3d& T);

/// Left Jacobian J of SE(3): exp(xi + d) ≈ exp(J d) exp(xi). Barfoot (7.85), with rotation first.
Matrix6 left_jacobian(const Vector6& twist);

/// Inverse of `left_jacobian`.
Matrix6 left_jacobian_inverse(const Vector6& twist);

/// Pose on the constant-twist path from A (u = 0) to B (u = 1); extrapolates for u outside 0 … 1.
Eigen::Isometry3d interpolate(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B, double u);

/// Transforms the covariance of a motion from frame b to frame a: adjoint(T_a_b) C adjoint(T_a_b)ᵀ.
Matrix6 transform_covariance(const Eigen::Isometry3d& T_a_b, const Matrix6& covariance);

}  // namespace infuse::geometry
