#pragma once

#include <Eigen/Core>
#include <span>

#include "fusion/dependence/instruction_set.hpp"

namespace infuse::dependence {

/// out[r] = Σ_c matrix(r, c) over the columns listed, in their order; `out` has matrix.rows()
/// entries. The bytes do not depend on the processor.
void sum_columns(const Eigen::MatrixXd& matrix, std::span<const int> columns, double* out,
                 InstructionSet set = best_instruction_set());

}  // namespace infuse::dependence
