#pragma once

#include <Eigen/Core>

#include "drivers/measurement/instruction_set.hpp"

namespace infuse::dependence {

/// View of a matrix of doubles with any strides.
struct MatrixView {
  const double* data = nullptr;
  Eigen::Index rows = 0;
  Eigen::Index columns = 0;
  Eigen::Index row_stride = 0;
  Eigen::Index column_stride = 0;
};

/// View of an Eigen matrix, block or transpose in memory (not of an expression).
template <class Derived>
MatrixView matrix_view(const Eigen::MatrixBase<Derived>& matrix) {
  static_assert((Derived::Flags & Eigen::DirectAccessBit) != 0, "evaluate the expression first");
  return {matrix.derived().data(), matrix.rows(), matrix.cols(), matrix.derived().rowStride(),
          matrix.derived().colStride()};
}

/// Computes out = a · b. `out` is column-major with `out_stride` doubles between columns and must
/// not overlap `a` or `b`. Each entry is summed in order of the inner index, without fused
/// multiply-adds: same bytes on every processor (Eigen's own product splits the sum by cache
/// sizes).
void multiply(const MatrixView& a, const MatrixView& b, double* out, Eigen::Index out_stride,
              InstructionSet set);

/// Computes out = a · aᵀ in half the time of `multiply`, exactly symmetric.
void multiply_by_transpose(const MatrixView& a, double* out, Eigen::Index out_stride,
                           InstructionSet set);

/// The same for Eigen matrices, blocks and transposes; resizes `out`.
template <class A, class B>
void multiply(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b, Eigen::MatrixXd& out,
              InstructionSet set = best_instruction_set()) {
  out.resize(a.rows(), b.cols());
  multiply(matrix_view(a), matrix_view(b), out.data(), out.rows(), set);
}

/// The same for Eigen matrices and blocks; resizes `out`.
template <class A>
void multiply_by_transpose(const Eigen::MatrixBase<A>& a, Eigen::MatrixXd& out,
                           InstructionSet set = best_instruction_set()) {
  out.resize(a.rows(), a.rows());
  multiply_by_transpose(matrix_view(a), out.data(), out.rows(), set);
}

}  // namespace infuse::dependence
