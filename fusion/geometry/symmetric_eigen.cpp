#include "fusion/geometry/symmetric_eigen.hpp"

#include <Eigen/Eigenvalues>

namespace infuse::geometry {

template <int N>
SymmetricEigen<N> symmetric_eigen(const Eigen::Matrix<double, N, N>& matrix) {
  constexpr int kMaxSize = 10;  // bounds memory: the largest of the instances below
  using Any = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxSize, kMaxSize>;
  const Eigen::SelfAdjointEigenSolver<Any> solver{Any(matrix)};
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template SymmetricEigen<1> symmetric_eigen(const Eigen::Matrix<double, 1, 1>&);
template SymmetricEigen<2> symmetric_eigen(const Eigen::Matrix<double, 2, 2>&);
template SymmetricEigen<3> symmetric_eigen(const Eigen::Matrix<double, 3, 3>&);
template SymmetricEigen<4> symmetric_eigen(const Eigen::Matrix<double, 4, 4>&);
template SymmetricEigen<5> symmetric_eigen(const Eigen::Matrix<double, 5, 5>&);
template SymmetricEigen<6> symmetric_eigen(const Eigen::Matrix<double, 6, 6>&);
template SymmetricEigen<10> symmetric_eigen(const Eigen::Matrix<double, 10, 10>&);

}  // namespace infuse::geometry
