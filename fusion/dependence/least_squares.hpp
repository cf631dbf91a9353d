#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fusion/dependence/estimate.hpp"

namespace infuse::dependence {

/// What a least-squares fit of densities measures. X is the prepared side, Y the other.
enum class FitMeasure {
  kSmi,  ///< squared-loss mutual information I(2.4), by LSMI I(2.7–2.8): the ratio
         ///< p(x, y)/(p(x)p(y)) is fitted; ≥ 0 in theory, estimates can fall slightly below
  kQmi,  ///< quadratic mutual information ∫∫(p(x, y) − p(x)p(y))², by LSQMI (Sainui and Sugiyama):
         ///< the difference is fitted
  kSce,  ///< squared-loss conditional entropy of Y given X, by LSCE (Tangkaratt, Sasaki and
         ///< Sugiyama): −½∫∫p(x, y)²/p(x), which leaves out the constant 1 − ½·volume(Y);
         ///< p(x, y)/p(x) is fitted; smaller means more dependent
};

/// Which of two consistent estimates of SMI is given from the fitted ratio r. The derivative of
/// both is offered.
enum class SmiForm {
  kLinear,  ///< ½·mean r(x_i, y_i) − ½: I(2.8)
  kPlugIn,  ///< mean r(x_i, y_i) − ½·mean r(x_i, y_j)² − ½: never below the linear one, and less
            ///< biased where dependence is strong
};

/// The hyper-parameters of a fit.
struct HyperParameters {
  double sigma = 0;   ///< Gaussian width, in the unit of the features
  double lambda = 0;  ///< ridge on the coefficients

  bool operator==(const HyperParameters&) const = default;
};

/// Settings of the fits. The grid is searched by cross-validation I 2.2.2.2; with one entry in each
/// list there is none.
struct FitOptions {
  int centres = 100;  ///< kernel centres, drawn from the samples; all samples where there are fewer
  std::vector<double> sigmas = {0.25, 0.5, 0.75, 1.0, 1.5};  ///< in the unit of the features: made
                                                             ///< for unit variance
  std::vector<double> lambdas = {1e-4, 1e-3, 1e-2, 1e-1, 1.0};  ///< ridge, without unit
  int folds = 5;                                                ///< of the cross-validation
  uint64_t seed = 1;  ///< draws the centres and deals the folds
  SmiForm form = SmiForm::kLinear;

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;

  /// The folds that are dealt: 1 where the grid leaves nothing to choose.
  int effective_folds() const { return sigmas.size() * lambdas.size() > 1 ? folds : 1; }
};

/// An estimate, and the hyper-parameters it assumed.
struct FitEstimate : Estimate {
  HyperParameters hyper_parameters;
};

}  // namespace infuse::dependence
