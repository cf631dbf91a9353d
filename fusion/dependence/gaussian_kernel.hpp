#pragma once

#include <Eigen/Core>
#include <vector>

#include "drivers/measurement/instruction_set.hpp"

namespace infuse::dependence {

/// Samples of one side: n × d, a row a sample, a column a feature.
using Samples = Eigen::Ref<const Eigen::MatrixXd>;

/// kernel(l, i) = exp(−|x_i − c_l|² / (2σ²)), centres × samples; resizes `kernel`. Values below
/// 1e-307 are 0. The bytes do not depend on the processor. All inputs finite, σ > 0.
void gaussian_kernel(const Samples& samples, const Samples& centres, double sigma,
                     Eigen::MatrixXd& kernel, InstructionSet set = best_instruction_set());

/// The same into centres × samples doubles at `kernel`, column-major; the centres' columns lie next
/// to each other. Allocates nothing.
void gaussian_kernel(const Samples& samples, const Eigen::MatrixXd& centres, double sigma,
                     double* kernel, InstructionSet set = best_instruction_set());

/// ∫ G(x, c_l) G(x, c_m) dx over all of ℝ^d: (πσ²)^(d/2) · exp(−|c_l − c_m|² / (4σ²)).
void gaussian_overlap(const Samples& centres, double sigma, Eigen::MatrixXd& overlap);

/// Takes the derivative of a scalar with respect to a kernel matrix on to the samples, through the
/// samples and through the centres, which are the rows `centre_rows` of `samples`.
/// `sensitivity` holds ∂S/∂kernel (centres × samples) and is overwritten; `gradient` (n × d) is
/// resized and set to ∂S/∂samples.
void gaussian_kernel_gradient(const Samples& samples, const std::vector<int>& centre_rows,
                              double sigma, const Eigen::MatrixXd& kernel,
                              Eigen::MatrixXd& sensitivity, Eigen::MatrixXd& gradient);

}  // namespace infuse::dependence
