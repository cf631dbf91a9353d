#pragma once

#include <Eigen/Core>
#include <vector>

#include "drivers/measurement/instruction_set.hpp"

namespace infuse::dependence {

/// Samples of one side: n × d, one row per sample, one column per feature.
using Samples = Eigen::Ref<const Eigen::MatrixXd>;

/// Computes kernel(l, i) = exp(−|x_i − c_l|² / (2σ²)), centres × samples; resizes `kernel`. Values
/// below 1e-307 are 0. Same bytes on every processor. All inputs finite, σ > 0.
void gaussian_kernel(const Samples& samples, const Samples& centres, double sigma,
                     Eigen::MatrixXd& kernel, InstructionSet set = best_instruction_set());

/// The same into centres × samples doubles at `kernel`, column-major; the columns of `centres` are
/// contiguous. Does not allocate.
void gaussian_kernel(const Samples& samples, const Eigen::MatrixXd& centres, double sigma,
                     double* kernel, InstructionSet set = best_instruction_set());

/// Computes ∫ G(x, c_l) G(x, c_m) dx over ℝ^d: (πσ²)^(d/2) · exp(−|c_l − c_m|² / (4σ²)).
void gaussian_overlap(const Samples& centres, double sigma, Eigen::MatrixXd& overlap);

/// Propagates the derivative of a scalar with respect to a kernel matrix to the samples, both as
/// samples and as centres, which are the rows `centre_rows` of `samples`. `sensitivity` holds
/// ∂S/∂kernel (centres × samples) and is overwritten; `gradient` (n × d) is resized and set to
/// ∂S/∂samples.
void gaussian_kernel_gradient(const Samples& samples, const std::vector<int>& centre_rows,
                              double sigma, const Eigen::MatrixXd& kernel,
                              Eigen::MatrixXd& sensitivity, Eigen::MatrixXd& gradient);

}  // namespace infuse::dependence
