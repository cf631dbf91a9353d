#pragma once

#include "fusion/dependence/estimate.hpp"
#include "fusion/dependence/gaussian_kernel.hpp"

namespace infuse::dependence {

/// What `distance_dependence` answers. `reason` holds for all three; it is "" where both sides
/// vary.
struct DistanceDependence {
  double covariance = 0;             ///< dCov, in √(unit of x · unit of y)
  double correlation = 0;            ///< dCor, 0 … 1
  double corrected_correlation = 0;  ///< bias-corrected dCor², may be negative; 0 below 4 samples
  const char* reason = "";           ///< static text, "" where the values can be used

  bool usable() const { return *reason == '\0'; }
};

/// Distance covariance and correlation (Székely, Rizzo and Bakirov; I 2.3.3) of n samples of x and
/// y, and the correlation after bias correction (Székely and Rizzo 2013). Exact: O(n log n) where
/// both sides have one feature, O(n²) time and O(n) memory otherwise.
DistanceDependence distance_dependence(const Samples& x, const Samples& y);

/// dCor alone, as an Estimate.
Estimate distance_correlation(const Samples& x, const Samples& y);

/// Bias-corrected dCor² alone, as an Estimate; needs four samples.
Estimate corrected_distance_correlation(const Samples& x, const Samples& y);

}  // namespace infuse::dependence
