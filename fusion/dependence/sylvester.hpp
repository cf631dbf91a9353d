#pragma once

#include <Eigen/Core>

namespace infuse::dependence {

/// Eigendecomposition of a symmetric Gram matrix: gram = rotationᵀ · diag(eigenvalues) · rotation.
struct SpectralBasis {
  Eigen::MatrixXd rotation;     ///< rows are eigenvectors
  Eigen::VectorXd eigenvalues;  ///< ≥ 0: negative rounding errors are clamped
};

/// Tridiagonal form of a symmetric Gram matrix: gram = rotationᵀ · T · rotation. Several times
/// faster than the eigendecomposition, and sufficient if the other side has one.
struct TridiagonalBasis {
  Eigen::MatrixXd rotation;     ///< empty: the identity
  Eigen::VectorXd diagonal;     ///< of T
  Eigen::VectorXd subdiagonal;  ///< of T; empty: T is diagonal
};

/// Computes eigenvalues and eigenvectors of a symmetric positive semi-definite matrix. The rotation
/// is empty if this failed.
SpectralBasis spectral_basis(const Eigen::MatrixXd& gram);

/// Computes Householder's tridiagonal form of a symmetric positive semi-definite matrix.
TridiagonalBasis tridiagonal_basis(const Eigen::MatrixXd& gram);

/// Solves the Sylvester equation I(2.7), P Θ A + λΘ = C, in rotated coordinates: P = diag(mu), A
/// tridiagonal or diagonal; row j of Θ solves (mu_j·A + λ)θ = c. Processes all rows in one sweep.
/// `theta` is resized; λ > 0.
void solve_sylvester(const Eigen::VectorXd& mu, const TridiagonalBasis& a, double lambda,
                     const Eigen::MatrixXd& c, Eigen::MatrixXd& theta);

}  // namespace infuse::dependence
