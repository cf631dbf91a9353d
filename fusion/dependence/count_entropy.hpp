#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fusion/dependence/estimate.hpp"

namespace infuse::dependence {

/// Entropy in nats of a discrete variable from its counts. Every function takes one count per word
/// of the vocabulary, including zeros (the vocabulary size is `counts.size()`), and rejects counts
/// that are negative, not finite, or all zero. Counts may be fractional (weighted samples) unless
/// stated otherwise.

/// Maximum likelihood, P(2.15) in P(2.4). Unusable with fewer observations than words: its bias is
/// then as large as its value.
Estimate entropy_maximum_likelihood(std::span<const double> counts);

/// Maximum likelihood plus (m − 1)/2n, with m the number of words observed. Same condition.
Estimate entropy_miller_madow(std::span<const double> counts);

/// Shrinkage coefficient and target of James–Stein.
struct Shrinkage {
  /// Target frequencies, one per word, with sum 1; empty: uniform.
  std::span<const double> target = {};
  /// 0 … 1; absent: the optimal λ_s, P(4.10), for integer counts of independent samples.
  std::optional<double> lambda;
};

/// James–Stein frequencies P(4.8).
struct ShrunkFrequencies {
  std::vector<double> frequencies;  ///< empty if there is a reason
  double lambda = 0;                ///< shrinkage used
  const char* reason = "";          ///< as in Estimate

  bool usable() const { return *reason == '\0'; }
};
ShrunkFrequencies james_stein_frequencies(std::span<const double> counts,
                                          const Shrinkage& shrinkage = {});

/// Entropy of the James–Stein frequencies.
Estimate entropy_james_stein(std::span<const double> counts, const Shrinkage& shrinkage = {});

/// Chao–Shen: Good–Turing coverage with Horvitz–Thompson, P(5.4) and P(5.5). For integer counts;
/// zeros have no effect. If every observation is a singleton, one is removed, so that the coverage
/// stays positive. The entropy may exceed ln K.
Estimate entropy_chao_shen(std::span<const double> counts);

/// Entropy estimator and its settings.
struct CountEntropyOptions {
  enum class Estimator {
    kMaximumLikelihood,
    kMillerMadow,
    kJamesStein,  ///< towards `shrinkage.target`
    kChaoShen,
  };
  Estimator estimator = Estimator::kMaximumLikelihood;
  Shrinkage shrinkage;  ///< for James–Stein
};

/// Returns the entropy by the selected estimator.
Estimate entropy(std::span<const double> counts, const CountEntropyOptions& options);

/// −Σ p ln p of frequencies as they are: no check, no correction.
double plug_in_entropy(std::span<const double> frequencies);

/// Returns why no estimator accepts `counts` (empty, negative, not finite, all zero), or "".
const char* check_counts(std::span<const double> counts);

/// True if all counts are integers.
bool all_integers(std::span<const double> counts);

}  // namespace infuse::dependence
