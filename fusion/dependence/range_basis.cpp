#include "fusion/dependence/range_basis.hpp"

#include <Eigen/QR>
#include <cmath>
#include <limits>

namespace infuse::dependence {

Eigen::MatrixXd range_basis(const Eigen::MatrixXd& gram) {
  const Eigen::Index size = gram.rows();
  Eigen::MatrixXd factor(size, size);  // gram = factor · factorᵀ
  Eigen::VectorXd rest = gram.diagonal();
  const double smallest =
      static_cast<double>(size) * std::numeric_limits<double>::epsilon() * rest.maxCoeff();
  Eigen::Index rank = 0, pivot = 0;
  while (rank < size && (rest.maxCoeff(&pivot) > smallest || rank == 0)) {
    auto column = factor.col(rank);
    column = gram.col(pivot);
    column.noalias() -= factor.leftCols(rank) * factor.row(pivot).head(rank).transpose();
    column /= std::sqrt(rest[pivot]);
    rest -= column.cwiseAbs2();
    rest[pivot] = 0;
    ++rank;
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> reduced(factor.leftCols(rank));
  const Eigen::MatrixXd columns = reduced.householderQ() * Eigen::MatrixXd::Identity(size, rank);
  return columns.transpose();
}

}  // namespace infuse::dependence
