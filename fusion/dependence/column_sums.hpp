#pragma once

#include <Eigen/Core>
#include <span>

#include "drivers/measurement/instruction_set.hpp"

namespace infuse::dependence {

/// Computes out[r] = Σ_c matrix(r, c) over the listed columns in their order; `matrix` is
/// column-major with `rows` rows, the size of `out`. Same bytes on every processor.
void sum_columns(const double* matrix, Eigen::Index rows, std::span<const int> columns, double* out,
                 InstructionSet set = best_instruction_set());

/// The same for an Eigen matrix.
inline void sum_columns(const Eigen::MatrixXd& matrix, std::span<const int> columns, double* out,
                        InstructionSet set = best_instruction_set()) {
  sum_columns(matrix.data(), matrix.rows(), columns, out, set);
}

}  // namespace infuse::dependence
