#pragma once

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/KroneckerProduct>
#include <vector>

#include "fusion/dependence/least_squares.hpp"
#include "fusion/dependence/sample_choice.hpp"
#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::dependence {

/// Few centres and folds for the plain fits, on a grid with more than one entry.
inline FitOptions small_grid() {
  FitOptions options;
  options.centres = 9;
  options.sigmas = {0.2, 0.6, 1.2};
  options.lambdas = {1e-3, 1e-2, 1e-1};
  options.folds = 4;
  return options;
}

/// Straightforward least-squares fits: kernels by std::exp, the b² × b² system of the product model
/// solved densely, held-out errors over all pairs of samples.
struct PlainFit {
  FitMeasure measure = FitMeasure::kSmi;
  SmiForm form = SmiForm::kLinear;
  Eigen::MatrixXd p, a;  ///< model matrices of a training set
  Eigen::MatrixXd c, theta;
  double lambda = 0;

  /// x, y: kernel values, centres × samples. p_integral, a_integral: ∫ΦΦᵀ if the measure needs
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

/// Returns exp(−|x_i − c_l|²/(2σ²)), centres × samples.
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

/// Returns ∫ G(x, c_l) G(x, c_m) dx.
inline Eigen::MatrixXd plain_integral(const Eigen::MatrixXd& centres, double sigma) {
  const double d = static_cast<double>(centres.cols());
  return plain_kernel(centres, centres, sigma * std::numbers::sqrt2) *
         std::pow(std::numbers::pi * sigma * sigma, d / 2);
}

/// Delta kernel: labels × samples.
inline Eigen::MatrixXd indicators(const std::vector<int32_t>& labels, int label_count) {
  Eigen::MatrixXd out =
      Eigen::MatrixXd::Zero(label_count, static_cast<Eigen::Index>(labels.size()));
  for (size_t i = 0; i < labels.size(); ++i) out(labels[i], static_cast<Eigen::Index>(i)) = 1;
  return out;
}

/// Labels that depend on the first feature.
inline std::vector<int32_t> make_labels(const Eigen::MatrixXd& x, int label_count, uint64_t seed) {
  const Eigen::MatrixXd noise = normal_samples(x.rows(), 1, seed);
  std::vector<int32_t> labels;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const double level = std::floor(label_count * (0.5 + 0.25 * (x(i, 0) + 0.5 * noise(i))));
    labels.push_back(static_cast<int32_t>(std::clamp(level, 0.0, label_count - 1.0)));
  }
  return labels;
}

/// Straightforward cross-validation with the same centres and folds.
inline HyperParameters plain_choice(FitMeasure measure, const Eigen::MatrixXd& x,
                                    const Eigen::MatrixXd* y, const std::vector<int32_t>& labels,
                                    int label_count, const FitOptions& options) {
  Random random(options.seed);
  const int n = static_cast<int>(x.rows());
  const std::vector<int> centres = choose_subset(n, options.centres, random);
  const Folds folds = make_folds(n, options.folds, random);
  double best_error = std::numeric_limits<double>::max();
  HyperParameters best;
  for (const double sigma : options.sigmas) {
    const Eigen::MatrixXd xc = x(centres, Eigen::all);
    const Eigen::MatrixXd phi = plain_kernel(x, xc, sigma);
    const Eigen::MatrixXd psi = y == nullptr ? indicators(labels, label_count)
                                             : plain_kernel(*y, (*y)(centres, Eigen::all), sigma);
    const Eigen::MatrixXd a_integral = y == nullptr
                                           ? Eigen::MatrixXd::Identity(label_count, label_count)
                                           : plain_integral((*y)(centres, Eigen::all), sigma);
    for (const double lambda : options.lambdas) {
      double error = 0;
      for (int f = 0; f < folds.count(); ++f) {
        std::vector<int> held_out, train;
        for (int i = 0; i < n; ++i) {
          const bool in = i >= folds.begin[static_cast<size_t>(f)] &&
                          i < folds.begin[static_cast<size_t>(f) + 1];
          (in ? held_out : train).push_back(folds.order[static_cast<size_t>(i)]);
        }
        const PlainFit fit(measure, phi(Eigen::all, train), psi(Eigen::all, train),
                           plain_integral(xc, sigma), a_integral, lambda);
        // Criterion of the held-out samples with the solution of the others.
        const PlainFit validation(measure, phi(Eigen::all, held_out), psi(Eigen::all, held_out),
                                  plain_integral(xc, sigma), a_integral, 1.0);
        error += 0.5 * fit.theta.cwiseProduct(validation.p * fit.theta * validation.a).sum() -
                 fit.theta.cwiseProduct(validation.c).sum();
        if (measure == FitMeasure::kSmi) {
          // I 2.2.2.2 as printed: ½ mean r(x_i, y_j)² − mean r(x_i, y_i).
          const Eigen::MatrixXd r =
              phi(Eigen::all, held_out).transpose() * fit.theta * psi(Eigen::all, held_out);
          EXPECT_NEAR(0.5 * r.array().square().mean() - r.diagonal().mean(),
                      0.5 * fit.theta.cwiseProduct(validation.p * fit.theta * validation.a).sum() -
                          fit.theta.cwiseProduct(validation.c).sum(),
                      1e-8);
        }
      }
      if (error < best_error) {
        best_error = error;
        best = {sigma, lambda};
      }
    }
  }
  return best;
}

}  // namespace infuse::dependence
