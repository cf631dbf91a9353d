#pragma once

#include <Eigen/Core>

namespace infuse::geometry {

/// Eigenvalues, ascending, and eigenvectors, as columns, of a symmetric matrix.
template <int N>
struct SymmetricEigen {
  Eigen::Matrix<double, N, 1> values;
  Eigen::Matrix<double, N, N> vectors;
};

/// Decomposes a symmetric matrix, of which the lower triangle is read; N is 1 ... 6 or 10.
/// Does not allocate. Eigen's solver takes 5 s of compilation for each size in each file that uses
/// it; here it is compiled once for all.
template <int N>
SymmetricEigen<N> symmetric_eigen(const Eigen::Matrix<double, N, N>& matrix);

}  // namespace infuse::geometry
