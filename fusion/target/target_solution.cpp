#include "fusion/target/target_solution.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace infuse::target {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kMinMisfit = 1e-5;  // m and rad; below what any sensor resolves
constexpr double kMaxMisfit = 0.1;   // m and rad; beyond the search for returns
constexpr int kLineSteps = 14;  // of golden section, rounded: log(kMaxMisfit ÷ kMinMisfit) to 0.01
constexpr double kMinShare = 0.01;  // of the pose's covariance; a view that adds less tells
                                    // nothing of this direction
constexpr int kLineSweeps = 2;      // over the two components

/// Minimum of a function between two numbers, by golden section.
template <class Function>
double minimise_between(double low, double high, const Function& function) {
  const double golden = 0.5 * (std::sqrt(5.0) - 1);
  double a = high - golden * (high - low), b = low + golden * (high - low);
  double at_a = function(a), at_b = function(b);
  for (int k = 0; k < kLineSteps; ++k) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      at_a = function(a = high - golden * (high - low));
    } else {
      low = a;
      a = b;
      at_a = at_b;
      at_b = function(b = low + golden * (high - low));
    }
  }
  return at_a < at_b ? a : b;
}

}  // namespace

ShiftCovariance Misfit::covariance() const {
  return BoardShift(offset * offset, tilt * tilt, tilt * tilt).asDiagonal();
}

Matrix6 TargetSolution::pose_covariance() const {
  const Eigen::MatrixXd all =
      information.ldlt().solve(Eigen::MatrixXd::Identity(information.rows(), 6));
  return 0.5 * (all.topRows<6>() + all.topRows<6>().transpose());
}

TargetSolution solve_views(std::span<const ViewEquations> views,
                           std::span<const ShiftCovariance> shift_covariances,
                           const Eigen::MatrixXd& prior, double noise) {
  TargetSolution out{.shared = {}, .information = prior, .views = {}};
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(prior.rows());
  double total = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    out.views.push_back(reduce_view(views[i], shift_covariances[i], noise));
    const ReducedView& view = out.views.back();
    out.information += view.information;
    gradient += view.gradient;
    total += view.chi_squared + view.log_determinant;
  }
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(out.information);
  out.shared = ldlt.solve(gradient);
  out.minus_two_log_likelihood =
      total - gradient.dot(out.shared) + ldlt.vectorD().cwiseAbs().array().log().sum();
  return out;
}

BoardShift fit_shift(const ViewEquations& view, const Eigen::VectorXd& shared) {
  return view.own.ldlt().solve(view.own_gradient - view.cross.transpose() * shared);
}

double remaining_squares(const ViewEquations& view, const Eigen::VectorXd& shared,
                         const BoardShift& shift) {
  return view.squares - 2 * view.shared_gradient.dot(shared) - 2 * view.own_gradient.dot(shift) +
         shared.dot(view.shared * shared) + 2 * shared.dot(view.cross * shift) +
         shift.dot(view.own * shift);
}

Misfit estimate_misfit(std::span<const ViewEquations> views,
                       std::span<const ShiftCovariance> corner_covariances,
                       const Eigen::MatrixXd& prior, double noise) {
  Misfit misfit{kMinMisfit, kMinMisfit};
  std::vector<ShiftCovariance> covariances(views.size());
  const auto at = [&](double& component, double logarithm) {
    component = std::exp(logarithm);
    for (size_t i = 0; i < views.size(); ++i) {
      covariances[i] = corner_covariances[i] + misfit.covariance();
    }
    return solve_views(views, covariances, prior, noise).minus_two_log_likelihood;
  };
  for (int sweep = 0; sweep < kLineSweeps; ++sweep) {
    for (double* component : {&misfit.tilt, &misfit.offset}) {
      *component = std::exp(minimise_between(std::log(kMinMisfit), std::log(kMaxMisfit),
                                             [&](double value) { return at(*component, value); }));
    }
  }
  return misfit;
}

double leave_one_out_ratio(const TargetSolution& solution) {
  const Matrix6 covariance = solution.pose_covariance();
  const Eigen::LLT<Matrix6> root(covariance);
  double squares = 0;
  double freedom = 0;
  for (const ReducedView& view : solution.views) {
    TargetSolution without{
        .shared = {}, .information = solution.information - view.information, .views = {}};
    // Without the view the solution is x + (I − Iᵥ)⁻¹ (Iᵥ x − gᵥ), where I x = g.
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(without.information);
    if (!ldlt.isPositive() || ldlt.vectorD().minCoeff() <= 0) continue;
    const Eigen::VectorXd change =
        ldlt.solve(Eigen::VectorXd(view.information * solution.shared - view.gradient));
    const Vector6 whitened = root.matrixL().solve(Vector6(change.head<6>()));
    const Matrix6 half = root.matrixL().solve(Matrix6(without.pose_covariance() - covariance));
    const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(
        Matrix6(root.matrixL().solve(Matrix6(half.transpose()))));
    for (int k = 0; k < 6; ++k) {
      if (eigen.eigenvalues()(k) < kMinShare) continue;
      const double along = eigen.eigenvectors().col(k).dot(whitened);
      squares += along * along / eigen.eigenvalues()(k);
      freedom += 1;
    }
  }
  return freedom > 0 ? squares / freedom : 0;
}

}  // namespace infuse::target
