#include "fusion/dependence/sylvester.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <unsupported/Eigen/KroneckerProduct>

#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::dependence {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_gram(Index size, Index rank, uint64_t seed) {
  const MatrixXd a = normal_samples(size, rank, seed);
  return a * a.transpose() / static_cast<double>(rank);
}

// P Θ A + λΘ = C as (A ⊗ P + λI) vec Θ = vec C.
MatrixXd dense_solution(const MatrixXd& p, const MatrixXd& a, double lambda, const MatrixXd& c) {
  MatrixXd matrix = Eigen::kroneckerProduct(a, p);
  matrix.diagonal().array() += lambda;
  const VectorXd theta = matrix.fullPivLu().solve(Map<const VectorXd>(c.data(), c.size()));
  return Map<const MatrixXd>(theta.data(), c.rows(), c.cols());
}

TEST(Sylvester, BasesReproduceTheMatrix) {
  for (const Index size : {1, 2, 3, 12}) {
    const MatrixXd gram = random_gram(size, 2 * size, 1);
    const SpectralBasis spectral = spectral_basis(gram);
    EXPECT_TRUE(
        (spectral.rotation.transpose() * spectral.eigenvalues.asDiagonal() * spectral.rotation)
            .isApprox(gram, 1e-12));
    const TridiagonalBasis basis = tridiagonal_basis(gram);
    MatrixXd t = basis.diagonal.asDiagonal();
    for (Index k = 0; k + 1 < size; ++k) t(k, k + 1) = t(k + 1, k) = basis.subdiagonal[k];
    const MatrixXd rotation =
        basis.rotation.size() == 0 ? MatrixXd::Identity(size, size) : basis.rotation;
    EXPECT_TRUE((rotation.transpose() * t * rotation).isApprox(gram, 1e-12));
  }
}

TEST(Sylvester, SolutionEqualsTheDenseKroneckerSolve) {
  for (const double lambda : {1e-4, 1e-2, 1.0}) {
    for (const Index size : {1, 2, 9}) {
      const MatrixXd p = random_gram(11, 20, 2), a = random_gram(size, 20, 3);
      const MatrixXd c = normal_samples(11, size, 4);
      const SpectralBasis fixed = spectral_basis(p);
      const TridiagonalBasis moving = tridiagonal_basis(a);
      const MatrixXd q = moving.rotation.size() == 0 ? MatrixXd::Identity(1, 1) : moving.rotation;
      MatrixXd theta;
      solve_sylvester(fixed.eigenvalues, moving, lambda, fixed.rotation * c * q.transpose(), theta);
      theta = fixed.rotation.transpose() * theta * q;
      EXPECT_TRUE(theta.isApprox(dense_solution(p, a, lambda, c), 1e-9)) << lambda << " " << size;
    }
  }
}

TEST(Sylvester, RidgeMakesSingularGramsSolvable) {
  const MatrixXd p = random_gram(10, 2, 5), a = MatrixXd::Ones(6, 6);
  const MatrixXd c = normal_samples(10, 6, 6);
  const SpectralBasis fixed = spectral_basis(p);
  const TridiagonalBasis moving = tridiagonal_basis(a);
  EXPECT_GE(fixed.eigenvalues.minCoeff(), 0.0);
  MatrixXd theta;
  solve_sylvester(fixed.eigenvalues, moving, 1e-3, fixed.rotation * c * moving.rotation.transpose(),
                  theta);
  theta = fixed.rotation.transpose() * theta * moving.rotation;
  EXPECT_TRUE(theta.isApprox(dense_solution(p, a, 1e-3, c), 1e-8));
}

}  // namespace
}  // namespace infuse::dependence
