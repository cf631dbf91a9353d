#include "fusion/mapping/block_cholesky.hpp"

#include <algorithm>

namespace infuse::mapping {

template <int B>
BlockCholesky<B>::BlockCholesky(size_t nodes, std::vector<std::pair<size_t, size_t>> pairs)
    : rows_(nodes) {
  for (size_t i = 0; i < nodes; ++i) rows_[i].push_back(i);
  for (const auto& [i, j] : pairs) rows_[std::min(i, j)].push_back(std::max(i, j));
  const auto size = static_cast<Eigen::Index>(nodes) * B;
  Eigen::VectorXi counts(size);
  for (size_t column = 0; column < nodes; ++column) {
    std::vector<size_t>& rows = rows_[column];
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    counts.segment<B>(static_cast<Eigen::Index>(column) * B)
        .setConstant(static_cast<int>(rows.size()) * B);
  }
  // Diagonal blocks are stored whole; the factorisation reads their lower triangles only.
  lower_.resize(size, size);
  lower_.reserve(counts);
  for (Eigen::Index c = 0; c < size; ++c) {
    for (const size_t row : rows_[static_cast<size_t>(c / B)]) {
      for (int r = 0; r < B; ++r) lower_.insert(static_cast<Eigen::Index>(row) * B + r, c) = 0;
    }
  }
  if (nodes > 0) lower_.makeCompressed();  // Eigen 3.4 reads outside an empty one
}

template <int B>
void BlockCholesky<B>::set_zero() {
  std::fill_n(lower_.valuePtr(), lower_.nonZeros(), 0.0);
}

template <int B>
void BlockCholesky<B>::add(size_t row, size_t column, const Block& block) {
  if (row < column) return add(column, row, block.transpose());
  const std::vector<size_t>& rows = rows_[column];
  const auto at = std::lower_bound(rows.begin(), rows.end(), row) - rows.begin();
  for (int c = 0; c < B; ++c) {
    const int begin = lower_.outerIndexPtr()[static_cast<Eigen::Index>(column) * B + c];
    Eigen::Map<Eigen::Matrix<double, B, 1>>(lower_.valuePtr() + begin + at * B) += block.col(c);
  }
}

template <int B>
bool BlockCholesky<B>::factorize(double damping) {
  damped_ = lower_;
  for (Eigen::Index c = 0; c < damped_.cols(); ++c) {
    damped_.valuePtr()[damped_.outerIndexPtr()[c] + c % B] *= 1 + damping;
  }
  if (!analysed_) factor_.analyzePattern(damped_);
  analysed_ = true;
  factor_.factorize(damped_);
  // A pivot of a singular matrix is zero but for rounding.
  return factor_.info() == Eigen::Success &&
         (damped_.cols() == 0 || factor_.vectorD().minCoeff() > 0);
}

template class BlockCholesky<1>;
template class BlockCholesky<2>;
template class BlockCholesky<3>;
template class BlockCholesky<6>;

}  // namespace infuse::mapping
