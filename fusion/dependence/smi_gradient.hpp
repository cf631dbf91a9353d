#pragma once

#include <Eigen/Core>

#include "fusion/dependence/least_squares.hpp"
#include "fusion/dependence/sylvester.hpp"

namespace infuse::dependence {

/// Solution of a product model of SMI, in the coordinates in which it was solved.
struct SmiSolution {
  const SpectralBasis& fixed;      ///< of Φ_P·Φ_Pᵀ/n
  const TridiagonalBasis& moving;  ///< of Φ_A·Φ_Aᵀ/n
  const Eigen::MatrixXd& theta;    ///< solution of I(2.7), rotated: prepared × other side
  double lambda = 0;
  SmiForm form = SmiForm::kLinear;
};

/// Computes ∂SMI/∂Φ_A with fixed σ and λ (centres × samples; `sensitivity` is resized), by the
/// adjoint of the Sylvester equation. For I(2.8) the adjoint is the solution itself: ∂S = ⟨Θ, ∂C⟩ −
/// ½⟨Θ, P Θ ∂A⟩. The plug-in form needs a second solve with the same factors.
void smi_sensitivity(const SmiSolution& solution, const Eigen::MatrixXd& fixed_features,
                     const Eigen::MatrixXd& moving_features, Eigen::MatrixXd& sensitivity);

}  // namespace infuse::dependence
