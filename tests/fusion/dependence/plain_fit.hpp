#pragma once

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/KroneckerProduct>
#include <vector>

#include "fusion/dependence/least_squares.hpp"

namespace infuse::dependence {

/// The least-squares fits written down plainly: kernels by std::exp, the product model's b² × b²
/// system solved densely, held-out errors by running over all pairs of samples.
struct PlainFit {
  FitMeasure measure = FitMeasure::kSmi;
  SmiForm form = SmiForm::kLinear;
  Eigen::MatrixXd p, a;  ///< model matrices of a training set
  Eigen::MatrixXd c, theta;
  double lambda = 0;

  /// x, y: kernel values, centres × samples. p_integral, a_integral: ∫ΦΦᵀ where the measure wants
  /// them.
  PlainFit(FitMeasure m, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
           const Eigen::MatrixXd& p_integral, const Eigen::MatrixXd& a_integral, double ridge)
      : measure(m), lambda(ridge) {
    const double n = static_cast<double>(x.cols());
    p = m == FitMeasure::kQmi ? p_integral : Eigen::MatrixXd(x * x.transpose() / n);
    a = m == FitMeasure::kSmi ? Eigen::MatrixXd(y * y.transpose() / n) : a_integral;
    c = x * y.transpose() / n;
    if (m == FitMeasure::kQmi) c -= x.rowwise().mean() * y.rowwise().mean().transpose();
    Eigen::MatrixXd system = Eigen::kroneckerProduct(a, p);
    system.diagonal().array() += ridge;
    const Eigen::VectorXd solution =
        system.partialPivLu().solve(Eigen::Map<const Eigen::VectorXd>(c.data(), c.size()));
    theta = Eigen::Map<const Eigen::MatrixXd>(solution.data(), c.rows(), c.cols());
  }

  double value() const {
    const double linear = theta.cwiseProduct(c).sum();
    const double quadratic = theta.cwiseProduct(p * theta * a).sum();
    switch (measure) {
      case FitMeasure::kSmi:
        return form == SmiForm::kLinear ? 0.5 * linear - 0.5 : linear - 0.5 * quadratic - 0.5;
      case FitMeasure::kQmi:
        return 2 * linear - quadratic;
      case FitMeasure::kSce:
        break;
    }
    return 0.5 * quadratic - linear;
  }
};

/// exp(−|x_i − c_l|²/(2σ²)), centres × samples.
inline Eigen::MatrixXd plain_kernel(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& centres,
                                    double sigma) {
  Eigen::MatrixXd kernel(centres.rows(), samples.rows());
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    for (Eigen::Index l = 0; l < centres.rows(); ++l) {
      kernel(l, i) =
          std::exp(-(samples.row(i) - centres.row(l)).squaredNorm() / (2 * sigma * sigma));
    }
  }
  return kernel;
}

/// ∫ G(x, c_l) G(x, c_m) dx.
inline Eigen::MatrixXd plain_integral(const Eigen::MatrixXd& centres, double sigma) {
  const double d = static_cast<double>(centres.cols());
  return plain_kernel(centres, centres, sigma * std::numbers::sqrt2) *
         std::pow(std::numbers::pi * sigma * sigma, d / 2);
}

/// The delta kernel: labels × samples.
inline Eigen::MatrixXd indicators(const std::vector<int32_t>& labels, int label_count) {
  Eigen::MatrixXd out =
      Eigen::MatrixXd::Zero(label_count, static_cast<Eigen::Index>(labels.size()));
  for (size_t i = 0; i < labels.size(); ++i) out(labels[i], static_cast<Eigen::Index>(i)) = 1;
  return out;
}

}  // namespace infuse::dependence
