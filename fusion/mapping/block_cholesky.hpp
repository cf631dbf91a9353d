#pragma once

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <cstddef>
#include <utility>
#include <vector>

namespace infuse::mapping {

/// Sparse symmetric matrix of B × B blocks and its factor L D Lᵀ, by Eigen's simplicial Cholesky:
/// without a BLAS, so that every processor gives the same bytes.
template <int B>
class BlockCholesky {
 public:
  using Block = Eigen::Matrix<double, B, B>;

  /// A matrix of zeros with room for the blocks (i, i) of all nodes, and for (i, j) and (j, i) of
  /// all pairs.
  BlockCholesky(size_t nodes, std::vector<std::pair<size_t, size_t>> pairs);

  void set_zero();

  /// Adds to block (row, column) and, where they differ, the transpose to block (column, row).
  void add(size_t row, size_t column, const Block& block);

  /// Factorises the matrix with its diagonal multiplied by 1 + `damping`. Returns false if that is
  /// not positive definite.
  bool factorize(double damping);

  /// Solution of A x = b by the last factor; b has B rows for each node.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const { return factor_.solve(b); }

 private:
  Eigen::SparseMatrix<double> lower_, damped_;
  std::vector<std::vector<size_t>> rows_;  // of the blocks in each column of blocks, sorted
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  bool analysed_ = false;
};

}  // namespace infuse::mapping
