#pragma once

#include <Eigen/Core>

namespace infuse::dependence {

/// Computes orthonormal rows that span the range of a symmetric positive semi-definite matrix, up
/// to rounding: rank × size. The Gram matrix of smooth kernels has a rank far below its size.
///
/// Cholesky's decomposition with diagonal pivoting; it ends where the largest remaining diagonal
/// entry is at most size · ε · the largest entry, as LAPACK's dpstrf does. At least one row.
Eigen::MatrixXd range_basis(const Eigen::MatrixXd& gram);

}  // namespace infuse::dependence
