#include "fusion/dependence/smi_gradient.hpp"

#include "fusion/dependence/matrix_product.hpp"

namespace infuse::dependence {
namespace {

// leftᵀ · middle · right; an empty `right` is the identity.
void rotate_back(const Eigen::MatrixXd& left, const Eigen::MatrixXd& middle,
                 const Eigen::MatrixXd& right, Eigen::MatrixXd& out) {
  if (right.size() == 0) return multiply(left.transpose(), middle, out);
  Eigen::MatrixXd half;
  multiply(middle, right, half);
  multiply(left.transpose(), half, out);
}

}  // namespace

void smi_sensitivity(const SmiSolution& solution, const Eigen::MatrixXd& prepared_features,
                     const Eigen::MatrixXd& asked_features, Eigen::MatrixXd& sensitivity) {
  const Eigen::VectorXd& mu = solution.prepared.eigenvalues;
  const Eigen::MatrixXd& theta = solution.theta;
  // S = ½⟨Θ, C⟩ (+ ½λ|Θ|² for the plug-in form), so ∂S = ⟨½Θ + Z, ∂C⟩ − ⟨Z, P Θ ∂A⟩ where Z solves
  // the equation for ½C (+ λΘ).
  Eigen::MatrixXd adjoint = 0.5 * theta;
  if (solution.form == SmiForm::kPlugIn) {
    Eigen::MatrixXd second;
    solve_sylvester(mu, solution.asked, solution.lambda, theta, second);
    adjoint += solution.lambda * second;
  }
  Eigen::MatrixXd of_gram;
  multiply(theta.transpose(), Eigen::MatrixXd(mu.asDiagonal() * adjoint), of_gram);
  of_gram = (of_gram + of_gram.transpose()).eval();

  Eigen::MatrixXd cross_factor, gram_factor, gram_part;
  rotate_back(solution.prepared.rotation, 0.5 * theta + adjoint, solution.asked.rotation,
              cross_factor);
  if (solution.asked.rotation.size() == 0) {
    gram_factor = of_gram;
  } else {
    rotate_back(solution.asked.rotation, of_gram, solution.asked.rotation, gram_factor);
  }
  multiply(cross_factor.transpose(), prepared_features, sensitivity);
  multiply(gram_factor, asked_features, gram_part);
  sensitivity = (sensitivity - gram_part) / static_cast<double>(asked_features.cols());
}

}  // namespace infuse::dependence
