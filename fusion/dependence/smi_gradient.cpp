#include "fusion/dependence/smi_gradient.hpp"

#include "fusion/dependence/matrix_product.hpp"

namespace infuse::dependence {
namespace {

// Returns leftᵀ · middle · right; an empty `right` is the identity.
void rotate_back(const Eigen::MatrixXd& left, const Eigen::MatrixXd& middle,
                 const Eigen::MatrixXd& right, Eigen::MatrixXd& out) {
  if (right.size() == 0) return multiply(left.transpose(), middle, out);
  Eigen::MatrixXd half;
  multiply(middle, right, half);
  multiply(left.transpose(), half, out);
}

}  // namespace

void smi_sensitivity(const SmiSolution& solution, const Eigen::MatrixXd& fixed_features,
                     const Eigen::MatrixXd& moving_features, Eigen::MatrixXd& sensitivity) {
  const Eigen::VectorXd& mu = solution.fixed.eigenvalues;
  const Eigen::MatrixXd& theta = solution.theta;
  // S = ½⟨Θ, C⟩ (+ ½λ|Θ|² for the plug-in form), so ∂S = ⟨½Θ + Z, ∂C⟩ − ⟨Z, P Θ ∂A⟩, where Z solves
  // the equation with right side ½C (+ λΘ).
  Eigen::MatrixXd adjoint = 0.5 * theta;
  if (solution.form == SmiForm::kPlugIn) {
    Eigen::MatrixXd second;
    solve_sylvester(mu, solution.moving, solution.lambda, theta, second);
    adjoint += solution.lambda * second;
  }
  Eigen::MatrixXd gram_gradient;
  multiply(theta.transpose(), Eigen::MatrixXd(mu.asDiagonal() * adjoint), gram_gradient);
  gram_gradient = (gram_gradient + gram_gradient.transpose()).eval();

  Eigen::MatrixXd cross_factor, gram_factor, gram_part;
  rotate_back(solution.fixed.rotation, 0.5 * theta + adjoint, solution.moving.rotation,
              cross_factor);
  if (solution.moving.rotation.size() == 0) {
    gram_factor = gram_gradient;
  } else {
    rotate_back(solution.moving.rotation, gram_gradient, solution.moving.rotation, gram_factor);
  }
  multiply(cross_factor.transpose(), fixed_features, sensitivity);
  multiply(gram_factor, moving_features, gram_part);
  sensitivity = (sensitivity - gram_part) / static_cast<double>(moving_features.cols());
}

}  // namespace infuse::dependence
