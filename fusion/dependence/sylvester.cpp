#include "fusion/dependence/sylvester.hpp"

#include <Eigen/Eigenvalues>

namespace infuse::dependence {

SpectralBasis spectral_basis(const Eigen::MatrixXd& gram) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  if (solver.info() != Eigen::Success) return {};
  return {solver.eigenvectors().transpose(), solver.eigenvalues().cwiseMax(0.0)};
}

TridiagonalBasis tridiagonal_basis(const Eigen::MatrixXd& gram) {
  if (gram.rows() == 1) return {{}, gram.diagonal(), {}};
  const Eigen::Tridiagonalization<Eigen::MatrixXd> reduced(gram);
  TridiagonalBasis basis;
  basis.rotation = reduced.matrixQ();
  basis.rotation.transposeInPlace();
  basis.diagonal = reduced.diagonal();
  basis.subdiagonal = reduced.subDiagonal();
  return basis;
}

void solve_sylvester(const Eigen::VectorXd& mu, const TridiagonalBasis& a, double lambda,
                     const Eigen::MatrixXd& c, Eigen::MatrixXd& theta) {
  const Eigen::Index columns = c.cols();
  theta.resize(c.rows(), columns);
  if (a.subdiagonal.size() == 0) {
    for (Eigen::Index k = 0; k < columns; ++k) {
      theta.col(k).array() = c.col(k).array() / (mu.array() * a.diagonal[k] + lambda);
    }
    return;
  }
  // Gaussian elimination without pivoting: the matrices are positive definite. `upper` is the
  // superdiagonal divided by the pivot.
  const auto m = mu.array();
  Eigen::ArrayXXd upper(c.rows(), columns), pivot(c.rows(), columns);
  pivot.col(0) = m * a.diagonal[0] + lambda;
  theta.col(0).array() = c.col(0).array() / pivot.col(0);
  for (Eigen::Index k = 1; k < columns; ++k) {
    const double s = a.subdiagonal[k - 1];
    upper.col(k - 1) = m * s / pivot.col(k - 1);
    pivot.col(k) = m * a.diagonal[k] + lambda - m * s * upper.col(k - 1);
    theta.col(k).array() = (c.col(k).array() - m * s * theta.col(k - 1).array()) / pivot.col(k);
  }
  for (Eigen::Index k = columns - 1; k-- > 0;) {
    theta.col(k).array() -= upper.col(k) * theta.col(k + 1).array();
  }
}

}  // namespace infuse::dependence
