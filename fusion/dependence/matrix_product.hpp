#pragma once

#include <Eigen/Core>

#include "drivers/measurement/instruction_set.hpp"

namespace infuse::dependence {

/// A matrix of doubles somewhere in memory, with any strides.
struct MatrixView {
  const double* data = nullptr;
  Eigen::Index rows = 0;
  Eigen::Index columns = 0;
  Eigen::Index row_stride = 0;
  Eigen::Index column_stride = 0;
};

/// A view of a matrix, block or transpose that lies in memory (not of an expression).
template <class Derived>
MatrixView matrix_view(const Eigen::MatrixBase<Derived>& matrix) {
  static_assert((Derived::Flags & Eigen::DirectAccessBit) != 0, "evaluate the expression first");
  return {matrix.derived().data(), matrix.rows(), matrix.cols(), matrix.derived().rowStride(),
          matrix.derived().colStride()};
}

/// out = a · b. `out` is column-major with `out_stride` doubles from column to column and must not
/// overlap `a` or `b`. Each entry is summed in order of the inner index, without fused
/// multiply-adds: the bytes do not depend on the processor (Eigen's own product splits the sum by
/// the size of the caches).
void multiply(const MatrixView& a, const MatrixView& b, double* out, Eigen::Index out_stride,
              InstructionSet set);

/// out = a · aᵀ, half of the work of `multiply`, exactly symmetric.
void multiply_by_transpose(const MatrixView& a, double* out, Eigen::Index out_stride,
                           InstructionSet set);

/// out = a · b for Eigen's matrices, blocks and transposes; resizes `out`.
template <class A, class B>
void multiply(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b, Eigen::MatrixXd& out,
              InstructionSet set = best_instruction_set()) {
  out.resize(a.rows(), b.cols());
  multiply(matrix_view(a), matrix_view(b), out.data(), out.rows(), set);
}

/// out = a · aᵀ for Eigen's matrices and blocks; resizes `out`.
template <class A>
void multiply_by_transpose(const Eigen::MatrixBase<A>& a, Eigen::MatrixXd& out,
                           InstructionSet set = best_instruction_set()) {
  out.resize(a.rows(), a.rows());
  multiply_by_transpose(matrix_view(a), out.data(), out.rows(), set);
}

}  // namespace infuse::dependence
