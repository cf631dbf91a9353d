#pragma once

#include "fusion/dependence/estimate.hpp"
#include "fusion/dependence/gaussian_kernel.hpp"

namespace infuse::study {

using dependence::Estimate;
using dependence::Samples;

/// Distance covariance and correlation. `reason` applies to all three values; it is "" if both
/// sides vary.
struct DistanceDependence {
  double covariance = 0;             ///< dCov, in √(unit of x · unit of y)
  double correlation = 0;            ///< dCor, 0 … 1
  double corrected_correlation = 0;  ///< bias-corrected dCor², may be negative; 0 below 4 samples
  const char* reason = "";           ///< static text, "" if the values are usable

  bool usable() const { return *reason == '\0'; }
};

/// Computes the distance covariance and correlation (Székely, Rizzo and Bakirov; I 2.3.3) of n
/// samples of x and y, and the bias-corrected correlation (Székely and Rizzo 2013). Exact: O(n log
/// n) if both sides have one feature, O(n²) time and O(n) memory otherwise.
DistanceDependence distance_dependence(const Samples& x, const Samples& y);

/// Returns dCor alone.
Estimate distance_correlation(const Samples& x, const Samples& y);

/// Returns the bias-corrected dCor² alone; needs four samples.
Estimate corrected_distance_correlation(const Samples& x, const Samples& y);

}  // namespace infuse::study
