#pragma once

#include <Eigen/Core>

#include "fusion/dependence/least_squares.hpp"
#include "fusion/dependence/sylvester.hpp"

namespace infuse::dependence {

/// A solved product model of SMI in the coordinates where it was solved.
struct SmiSolution {
  const SpectralBasis& fixed;      ///< of Φ_P·Φ_Pᵀ/n
  const TridiagonalBasis& moving;  ///< of Φ_A·Φ_Aᵀ/n
  const Eigen::MatrixXd& theta;    ///< solution of I(2.7), rotated: prepared × asked
  double lambda = 0;
  SmiForm form = SmiForm::kLinear;
};

/// ∂SMI/∂Φ_A with σ and λ held (centres × samples; `sensitivity` is resized), by the adjoint of
/// the Sylvester equation. For I(2.8) the adjoint is the solution itself:
/// ∂S = ⟨Θ, ∂C⟩ − ½⟨Θ, P Θ ∂A⟩. The plug-in form takes a second solve by the same factors.
void smi_sensitivity(const SmiSolution& solution, const Eigen::MatrixXd& fixed_features,
                     const Eigen::MatrixXd& moving_features, Eigen::MatrixXd& sensitivity);

}  // namespace infuse::dependence
