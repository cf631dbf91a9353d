#pragma once

namespace infuse::calibration {

/// Probability that χ² exceeds `value`; 1 with no degree of freedom.
double chi_squared_exceeded(double value, int degrees_of_freedom);

/// Probability that F(6, degrees_of_freedom) exceeds `value`; degrees_of_freedom > 0.
double fisher6_exceeded(double value, double degrees_of_freedom);

/// Returns the ratio of the 95 % quantiles of 6 F(6, `degrees_of_freedom`) and χ²(6): by how much
/// a covariance is widened that is itself estimated.
double widening_of_few(double degrees_of_freedom);

}  // namespace infuse::calibration
