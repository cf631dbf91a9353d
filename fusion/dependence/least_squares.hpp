#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fusion/dependence/estimate.hpp"

namespace infuse::dependence {

/// Measure of a least-squares density fit. X is the prepared side, Y the other.
enum class FitMeasure {
  kSmi,  ///< squared-loss mutual information I(2.4), by LSMI I(2.7–2.8): fits the ratio p(x,
         ///< y)/(p(x)p(y)); ≥ 0 in theory, estimates can be slightly negative
  kQmi,  ///< quadratic mutual information ∫∫(p(x, y) − p(x)p(y))², by LSQMI (Sainui and Sugiyama):
         ///< fits the difference
  kSce,  ///< squared-loss conditional entropy of Y given X, by LSCE (Tangkaratt, Sasaki and
         ///< Sugiyama): −½∫∫p(x, y)²/p(x), without the constant 1 − ½·volume(Y); fits p(x, y)/p(x);
         ///< decreases with dependence
};

/// Estimate of SMI from the fitted ratio r; both are consistent and have derivatives.
enum class SmiForm {
  kLinear,  ///< ½·mean r(x_i, y_i) − ½: I(2.8)
  kPlugIn,  ///< mean r(x_i, y_i) − ½·mean r(x_i, y_j)² − ½: never below the linear form, and less
            ///< biased for strong dependence
};

/// Hyper-parameters of a fit.
struct HyperParameters {
  double sigma = 0;   ///< width of the Gaussian kernel, in the unit of the features
  double lambda = 0;  ///< ridge on the coefficients

  bool operator==(const HyperParameters&) const = default;
};

/// Settings of the fits. The grid is searched by cross-validation I 2.2.2.2; with one entry in each
/// list there is no search.
struct FitOptions {
  int centres = 100;  ///< number of kernel centres, drawn from the samples; all samples if there
                      ///< are fewer
  std::vector<double> sigmas = {0.25, 0.5, 0.75, 1.0, 1.5};  ///< in the unit of the features; the
                                                             ///< default suits unit variance
  std::vector<double> lambdas = {1e-4, 1e-3, 1e-2, 1e-1, 1.0};  ///< ridge, dimensionless
  int folds = 5;                                                ///< of the cross-validation
  uint64_t seed = 1;  ///< draws the centres and assigns the folds
  SmiForm form = SmiForm::kLinear;

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;

  /// Number of folds: 1 if the grid leaves nothing to choose.
  int effective_folds() const { return sigmas.size() * lambdas.size() > 1 ? folds : 1; }
};

/// Estimate with the hyper-parameters of its fit.
struct FitEstimate : Estimate {
  HyperParameters hyper_parameters;
};

}  // namespace infuse::dependence
