#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fusion/dependence/estimate.hpp"

namespace infuse::dependence {

/// Entropy in nats of a discrete variable from its counts. Every function takes one count a word of
/// the vocabulary, zeros included (the vocabulary size is `counts.size()`), and refuses counts that
/// are negative, not finite, or all zero. Counts may be fractional (weighted samples) except where
/// a function says otherwise.

/// Maximum likelihood, P(2.15) in P(2.4). Not usable with fewer observations than words: its bias
/// is then of the size of its value.
Estimate entropy_maximum_likelihood(std::span<const double> counts);

/// Maximum likelihood plus (m − 1)/2n, m the number of words seen. Same condition.
Estimate entropy_miller_madow(std::span<const double> counts);

/// How far James–Stein shrinks, and toward what.
struct Shrinkage {
  /// Target frequencies, one a word, summing to 1; empty: uniform.
  std::span<const double> target = {};
  /// 0 … 1; absent: the optimal λ_s, P(4.10), for whole-numbered counts of independent samples.
  std::optional<double> lambda;
};

/// James–Stein frequencies P(4.8) and what was assumed.
struct ShrunkFrequencies {
  std::vector<double> frequencies;  ///< empty where there is a reason
  double lambda = 0;                ///< the shrinkage that was used
  const char* reason = "";          ///< as in Estimate

  bool usable() const { return *reason == '\0'; }
};
ShrunkFrequencies james_stein_frequencies(std::span<const double> counts,
                                          const Shrinkage& shrinkage = {});

/// Entropy of the James–Stein frequencies.
Estimate entropy_james_stein(std::span<const double> counts, const Shrinkage& shrinkage = {});

/// Direction of the fast shrinkage coefficient.
enum class FastShrinkage {
  kAsPrinted,  ///< more correspondences shrink more: 0 at none, toward 1 at many
  kReversed,   ///< more correspondences shrink less: one minus the printed value
};

/// The O(1) shrinkage λ_e = 2/(1 + exp(−c/σ)) − 1, P(4.11), 0 … 1.
/// @param correspondences c, how many codewords found a partner
/// @param sigma           σ, about the usual number of codewords in a scan
/// Arguments that are not finite, a negative c or a σ ≤ 0 give 1 (the target alone).
double fast_shrinkage(double correspondences, double sigma,
                      FastShrinkage direction = FastShrinkage::kReversed);

/// Entropy of the frequencies (y_k + α)/(n + Kα), P(2.19). Usual α: Jeffreys ½, Laplace 1, and
/// below Perks 1/K and minimax √n/K.
Estimate entropy_dirichlet(std::span<const double> counts, double alpha);
double perks_alpha(std::span<const double> counts);
double minimax_alpha(std::span<const double> counts);

/// Chao–Shen: Good–Turing coverage with Horvitz–Thompson, P(5.4) and P(5.5). For whole-numbered
/// counts; zeros have no effect. Where every observation is a singleton, one is taken off, so that
/// the coverage stays above zero. It may exceed ln K.
Estimate entropy_chao_shen(std::span<const double> counts);

/// Which entropy-of-counts estimator to use; with what.
struct CountEntropyOptions {
  enum class Estimator {
    kMaximumLikelihood,
    kMillerMadow,
    kJamesStein,  ///< toward `shrinkage.target`
    kDirichlet,   ///< with `alpha`
    kNemenman,    ///< Dirichlet mixture, nemenman.hpp
    kChaoShen,
  };
  Estimator estimator = Estimator::kMaximumLikelihood;
  double alpha = 0.5;   ///< Dirichlet pseudo-count a word
  Shrinkage shrinkage;  ///< for James–Stein
};

/// The entropy by the estimator named.
Estimate entropy(std::span<const double> counts, const CountEntropyOptions& options);

/// −Σ p ln p of frequencies as they are: no check, no correction.
double plug_in_entropy(std::span<const double> frequencies);

/// Why `counts` cannot be used by any estimator (empty, negative, not finite, all zero), or "".
const char* check_counts(std::span<const double> counts);

/// Whether all counts are whole numbers.
bool all_integers(std::span<const double> counts);

}  // namespace infuse::dependence
