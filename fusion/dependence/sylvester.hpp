#pragma once

#include <Eigen/Core>

namespace infuse::dependence {

/// A symmetric Gram matrix by its eigenvalues: gram = rotationᵀ · diag(eigenvalues) · rotation.
struct SpectralBasis {
  Eigen::MatrixXd rotation;     ///< rows are eigenvectors
  Eigen::VectorXd eigenvalues;  ///< ≥ 0: rounding below zero is cut off
};

/// A symmetric Gram matrix by a tridiagonal one: gram = rotationᵀ · T · rotation. Found several
/// times faster than eigenvalues, and as good where the other side has them.
struct TridiagonalBasis {
  Eigen::MatrixXd rotation;     ///< empty for the identity
  Eigen::VectorXd diagonal;     ///< of T
  Eigen::VectorXd subdiagonal;  ///< of T; empty where T is diagonal
};

/// Eigenvalues and eigenvectors of a symmetric positive semi-definite matrix. An empty rotation
/// says that they were not found.
SpectralBasis spectral_basis(const Eigen::MatrixXd& gram);

/// Householder's tridiagonal form of a symmetric positive semi-definite matrix.
TridiagonalBasis tridiagonal_basis(const Eigen::MatrixXd& gram);

/// Solves the Sylvester equation I(2.7), P Θ A + λΘ = C, in rotated coordinates: P = diag(mu), A
/// tridiagonal or diagonal; row j of Θ solves (mu_j·A + λ)θ = c. All rows in one sweep. `theta` is
/// resized; λ > 0.
void solve_sylvester(const Eigen::VectorXd& mu, const TridiagonalBasis& a, double lambda,
                     const Eigen::MatrixXd& c, Eigen::MatrixXd& theta);

}  // namespace infuse::dependence
