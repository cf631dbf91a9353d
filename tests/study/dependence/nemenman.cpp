#include "tests/study/dependence/nemenman.hpp"

#include <algorithm>
#include <array>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/study/dependence/count_entropy.hpp"

namespace infuse::study {
namespace {

using boost::math::digamma;
using boost::math::trigamma;

/// A count and the number of words that have it.
struct Multiplicity {
  double count;
  double words;
};

std::vector<Multiplicity> multiplicities(std::span<const double> counts) {
  std::vector<double> sorted(counts.begin(), counts.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<Multiplicity> grouped;
  for (const double c : sorted) {
    if (grouped.empty() || grouped.back().count != c) grouped.push_back({c, 0});
    grouped.back().words += 1;
  }
  return grouped;
}

/// ln Γ(x + n) − ln Γ(x) without the cancellation of two large values.
double log_rising_factorial(double x, double n) {
  double shift = 0;  // raise x until the Stirling series has full precision
  while (x < 12) {
    shift += std::log((x + n) / x);
    x += 1;
  }
  const auto series = [](double z) {
    const double w = 1 / (z * z);
    return (1.0 / 12 - w * (1.0 / 360 - w * (1.0 / 1260 - w / 1680))) / z;
  };
  return (x - 0.5) * std::log1p(n / x) + n * std::log(x + n) - n + series(x + n) - series(x) -
         shift;
}

/// dξ/d ln β with ξ(β) = ψ(Kβ + 1) − ψ(β + 1), the expected entropy before any observation.
double entropy_density(double beta, double words) {
  if (beta < 1e4) {
    return beta * (words * trigamma(words * beta + 1) - trigamma(beta + 1));
  }
  const double k = 1 / words;  // the difference of the two asymptotic series, term by term
  const double w = 1 / beta;
  return w * ((1 - k) / 2 - w * (1 - k * k) / 6);
}

/// Posterior at one β: log density over ln β, and expected entropy.
struct PosteriorPoint {
  double log_density;
  double entropy;
};

PosteriorPoint posterior(std::span<const Multiplicity> grouped, double words, double n,
                         double beta) {
  PosteriorPoint point{std::log(entropy_density(beta, words)), digamma(n + words * beta + 1)};
  point.log_density -= log_rising_factorial(words * beta, n);
  for (const auto& [count, times] : grouped) {
    if (count > 0) point.log_density += times * log_rising_factorial(beta, count);
    point.entropy -= times * (count + beta) / (n + words * beta) * digamma(count + beta + 1);
  }
  return point;
}

}  // namespace

Estimate entropy_nemenman(std::span<const double> counts) {
  if (const char* reason = check_counts(counts); *reason) return {0, reason};
  if (counts.size() == 1) return {0, ""};
  const std::vector<Multiplicity> grouped = multiplicities(counts);
  const auto words = static_cast<double>(counts.size());
  const double n = std::accumulate(counts.begin(), counts.end(), 0.0);

  // Trapezoid rule over ln β: the integrand is smooth and decays exponentially at both ends, where
  // the rule converges faster than any power of the step.
  constexpr double kMinLogBeta = -36, kMaxLogBeta = 36, kLogBetaStep = 1.0 / 16;
  constexpr auto kPointCount = static_cast<size_t>((kMaxLogBeta - kMinLogBeta) / kLogBetaStep) + 1;
  std::array<PosteriorPoint, kPointCount> points;
  double peak = -INFINITY;
  for (size_t i = 0; i < kPointCount; ++i) {
    const double log_beta = kMinLogBeta + kLogBetaStep * static_cast<double>(i);
    points[i] = posterior(grouped, words, n, std::exp(log_beta));
    peak = std::max(peak, points[i].log_density);
  }
  double mass = 0, entropy = 0;
  for (const PosteriorPoint& point : points) {
    const double weight = std::exp(point.log_density - peak);
    mass += weight;
    entropy += weight * point.entropy;
  }
  if (!(mass > 0) || !std::isfinite(entropy)) return {0, "the counts are too large to integrate"};
  return {std::clamp(entropy / mass, 0.0, std::log(words)), ""};
}

}  // namespace infuse::study
