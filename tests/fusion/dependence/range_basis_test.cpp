#include "fusion/dependence/range_basis.hpp"

#include <gtest/gtest.h>

#include "fusion/dependence/gaussian_kernel.hpp"

namespace infuse::dependence {
namespace {

using Eigen::MatrixXd;

TEST(RangeBasis, SpansARangeOfKnownRank) {
  std::srand(1);  // of Eigen's Random
  for (const int rank : {1, 3, 12}) {
    const MatrixXd factor = MatrixXd::Random(12, rank);
    const MatrixXd gram = factor * factor.transpose();
    const MatrixXd basis = range_basis(gram);
    ASSERT_EQ(basis.rows(), rank);
    EXPECT_LT((basis * basis.transpose() - MatrixXd::Identity(rank, rank)).norm(), 1e-13);
    EXPECT_LT((basis.transpose() * basis * factor - factor).norm(), 1e-13 * factor.norm());
  }
  EXPECT_EQ(range_basis(MatrixXd::Zero(4, 4)).rows(), 1);
}

// 100 kernels of the width of their range: their rank is a sixth of their number.
TEST(RangeBasis, KeepsTheGramMatrixOfWideKernels) {
  const MatrixXd x = Eigen::VectorXd::LinSpaced(100, -2, 2);
  MatrixXd features;
  gaussian_kernel(x, x, 1.0, features);
  const MatrixXd gram = features * features.transpose();
  const MatrixXd basis = range_basis(gram);
  EXPECT_LT(basis.rows(), 20);
  const MatrixXd kept = basis.transpose() * (basis * gram * basis.transpose()) * basis;
  EXPECT_LT((kept - gram).norm(), 1e-12 * gram.norm());
}

}  // namespace
}  // namespace infuse::dependence
