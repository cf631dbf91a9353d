#include "fusion/calibration/distributions.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace infuse::calibration {
namespace {

/// Probability that 6 F(6, ν) exceeds a value. In closed form, as 6 is even: y^b Σ_{i<3} (b)_i
/// (1 − y)^i / i!, y = ν / (ν + 6 f), b = ν / 2.
double six_fisher6_exceeded(double value, double degrees_of_freedom) {
  const double y = degrees_of_freedom / (degrees_of_freedom + value);
  const double b = degrees_of_freedom / 2;
  return std::pow(y, b) * (1 + b * (1 - y) + b * (b + 1) / 2 * (1 - y) * (1 - y));
}

}  // namespace

double chi_squared_exceeded(double value, int degrees_of_freedom) {
  if (degrees_of_freedom <= 0 || !(value > 0)) return 1;
  if (std::isinf(value)) return 0;
  const boost::math::chi_squared distribution(degrees_of_freedom);
  return boost::math::cdf(boost::math::complement(distribution, value));
}

double fisher6_exceeded(double value, double degrees_of_freedom) {
  return six_fisher6_exceeded(6 * std::max(value, 0.0), degrees_of_freedom);
}

double widening_of_few(double degrees_of_freedom) {
  constexpr double kChiSquare = 12.591587;  // 95 % of 6 degrees of freedom
  double low = kChiSquare, high = 2 * kChiSquare;
  while (six_fisher6_exceeded(high, degrees_of_freedom) > 0.05 && high < 1e9) high *= 2;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (six_fisher6_exceeded(middle, degrees_of_freedom) > 0.05 ? low : high) = middle;
  }
  return low / kChiSquare;
}

}  // namespace infuse::calibration
