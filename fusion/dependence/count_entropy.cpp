#include "fusion/dependence/count_entropy.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace infuse::dependence {
namespace {

constexpr const char* kFewerSamplesThanWords =
    "fewer observations than words: use James-Stein or Chao-Shen";

double sum(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double minus_p_log_p(double p) { return p > 0 ? -p * std::log(p) : 0; }

const char* check_target(std::span<const double> target, size_t words) {
  if (target.size() != words) return "the target and the counts differ in size";
  for (const double t : target) {
    if (!(t >= 0 && t <= 1))
      return "the target is not a distribution: a value is not between 0 and 1";
  }
  if (std::abs(sum(target) - 1) > 1e-6) return "the target is not a distribution: its sum is not 1";
  return "";
}

/// λ_s of P(4.10). The target is fixed, so that its covariance with the frequencies is zero, and
/// Var(p̂_k) = p̂_k (1 − p̂_k)/(n − 1).
double optimal_shrinkage(std::span<const double> frequencies, double n,
                         std::span<const double> target) {
  if (n <= 1) return 1;
  double variance = 0, distance = 0;
  const double uniform = 1 / static_cast<double>(frequencies.size());
  for (size_t k = 0; k < frequencies.size(); ++k) {
    const double p = frequencies[k];
    const double gap = p - (target.empty() ? uniform : target[k]);
    variance += p * (1 - p);
    distance += gap * gap;
  }
  if (distance <= 0) return 1;
  return std::clamp(variance / ((n - 1) * distance), 0.0, 1.0);
}

}  // namespace

double plug_in_entropy(std::span<const double> frequencies) {
  double h = 0;
  for (const double p : frequencies) h += minus_p_log_p(p);
  return h;
}

const char* check_counts(std::span<const double> counts) {
  if (counts.empty()) return "no counts";
  constexpr double kMaxCount = 1e15;  // integers and their sums are exact in double precision
  for (const double c : counts) {
    if (!(c >= 0)) return "a count is negative or not a number";
    if (c > kMaxCount) return "a count is above 1e15";
  }
  return sum(counts) > 0 ? "" : "all counts are zero";
}

bool all_integers(std::span<const double> counts) {
  return std::all_of(counts.begin(), counts.end(), [](double c) { return c == std::floor(c); });
}

Estimate entropy_maximum_likelihood(std::span<const double> counts) {
  if (const char* reason = check_counts(counts); *reason) return {0, reason};
  const double n = sum(counts);
  double h = 0;
  for (const double c : counts) h += minus_p_log_p(c / n);
  return {h, n < static_cast<double>(counts.size()) ? kFewerSamplesThanWords : ""};
}

Estimate entropy_miller_madow(std::span<const double> counts) {
  Estimate estimate = entropy_maximum_likelihood(counts);
  if (*check_counts(counts)) return estimate;
  const auto seen = std::count_if(counts.begin(), counts.end(), [](double c) { return c > 0; });
  estimate.value += static_cast<double>(seen - 1) / (2 * sum(counts));
  return estimate;
}

ShrunkFrequencies james_stein_frequencies(std::span<const double> counts,
                                          const Shrinkage& shrinkage) {
  ShrunkFrequencies shrunk;
  shrunk.reason = check_counts(counts);
  if (shrunk.usable() && !shrinkage.target.empty()) {
    shrunk.reason = check_target(shrinkage.target, counts.size());
  }
  if (shrinkage.lambda && !(*shrinkage.lambda >= 0 && *shrinkage.lambda <= 1)) {
    shrunk.reason = "the shrinkage is not between 0 and 1";
  }
  if (!shrunk.usable()) return shrunk;

  const double n = sum(counts);
  shrunk.frequencies.assign(counts.begin(), counts.end());
  for (double& p : shrunk.frequencies) p /= n;
  shrunk.lambda =
      shrinkage.lambda.value_or(optimal_shrinkage(shrunk.frequencies, n, shrinkage.target));
  const double uniform = 1 / static_cast<double>(counts.size());
  for (size_t k = 0; k < counts.size(); ++k) {
    const double target = shrinkage.target.empty() ? uniform : shrinkage.target[k];
    shrunk.frequencies[k] = shrunk.lambda * target + (1 - shrunk.lambda) * shrunk.frequencies[k];
  }
  return shrunk;
}

Estimate entropy_james_stein(std::span<const double> counts, const Shrinkage& shrinkage) {
  const ShrunkFrequencies shrunk = james_stein_frequencies(counts, shrinkage);
  return {plug_in_entropy(shrunk.frequencies), shrunk.reason};
}

Estimate entropy_chao_shen(std::span<const double> counts) {
  if (const char* reason = check_counts(counts); *reason) return {0, reason};
  if (!all_integers(counts)) return {0, "Chao-Shen needs whole-numbered counts"};
  const double n = sum(counts);
  auto singletons = static_cast<double>(std::count(counts.begin(), counts.end(), 1.0));
  if (singletons == n) singletons -= 1;
  const double coverage = 1 - singletons / n;
  double h = 0;
  for (const double c : counts) {
    if (c == 0) continue;
    const double p = coverage * c / n;
    const double seen = p < 1 ? -std::expm1(n * std::log1p(-p)) : 1;  // 1 − (1 − p)ⁿ
    h += minus_p_log_p(p) / seen;
  }
  return {h, ""};
}

Estimate entropy(std::span<const double> counts, const CountEntropyOptions& options) {
  switch (options.estimator) {
    case CountEntropyOptions::Estimator::kMaximumLikelihood:
      return entropy_maximum_likelihood(counts);
    case CountEntropyOptions::Estimator::kMillerMadow:
      return entropy_miller_madow(counts);
    case CountEntropyOptions::Estimator::kJamesStein:
      return entropy_james_stein(counts, options.shrinkage);
    case CountEntropyOptions::Estimator::kChaoShen:
      return entropy_chao_shen(counts);
  }
  return {0, "unknown estimator"};
}

}  // namespace infuse::dependence
