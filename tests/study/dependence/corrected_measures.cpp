#include "tests/study/dependence/corrected_measures.hpp"

#include <string_view>
#include <utility>
#include <vector>

namespace infuse::study {
namespace {

using dependence::JointHistogram;
using dependence::Measure;
using EntropyEstimator = CountEntropyOptions::Estimator;

bool supports_few_samples(EntropyEstimator estimator) {
  return estimator != EntropyEstimator::kMaximumLikelihood &&
         estimator != EntropyEstimator::kMillerMadow;
}

/// The histogram's reason, unless the estimator lifts it.
const char* remaining_reason(const JointHistogram& histogram, const CountEntropyOptions& options) {
  const bool few = std::string_view(histogram.reason) == dependence::kFewerSamplesThanBins;
  return few && supports_few_samples(options.estimator) ? "" : histogram.reason;
}

Estimate measure_regularised(Measure which, JointHistogram histogram,
                             const CountEntropyOptions& options) {
  if (options.estimator == EntropyEstimator::kJamesStein) {
    ShrunkFrequencies shrunk = james_stein_frequencies(histogram.mass, options.shrinkage);
    if (!shrunk.usable()) return {0, shrunk.reason};
    histogram.mass = std::move(shrunk.frequencies);
  } else {
    if (!(options.alpha >= 0 && options.alpha <= 1e15)) return {0, "alpha is not in 0 … 1e15"};
    for (double& m : histogram.mass) m += options.alpha;
  }
  histogram.total = 0;
  for (const double m : histogram.mass) histogram.total += m;
  return {dependence::measure(which, histogram).value, remaining_reason(histogram, options)};
}

Estimate measure_corrected(Measure which, const JointHistogram& histogram,
                           const CountEntropyOptions& options) {
  if (which == Measure::kChiSquared || which == Measure::kSquaredLossMutualInformation) {
    return {0, "this measure has no entropies to correct: use James-Stein or Dirichlet"};
  }
  std::vector<double> mass_x(static_cast<size_t>(histogram.bins_x));
  std::vector<double> mass_y(static_cast<size_t>(histogram.bins_y));
  for (int i = 0; i < histogram.bins_x; ++i) {
    for (int j = 0; j < histogram.bins_y; ++j) {
      mass_x[static_cast<size_t>(i)] += histogram.at(i, j);
      mass_y[static_cast<size_t>(j)] += histogram.at(i, j);
    }
  }
  const Estimate x = entropy(mass_x, options), y = entropy(mass_y, options);
  const Estimate xy = entropy(histogram.mass, options);
  // A joint table usually has fewer samples than cells; this alone is no reason.
  if (supports_few_samples(options.estimator)) {
    for (const Estimate& h : {x, y, xy}) {
      if (!h.usable()) return {0, h.reason};
    }
  }
  const double information = x.value + y.value - xy.value;
  const double normalised = xy.value > 0 ? (x.value + y.value) / xy.value : 1;
  const double value = which == Measure::kMutualInformation ? information : normalised;
  return {value, remaining_reason(histogram, options)};
}

}  // namespace

Estimate measure(Measure which, const JointHistogram& histogram,
                 const CountEntropyOptions& options) {
  const bool plug_in = options.estimator == EntropyEstimator::kMaximumLikelihood;
  if (plug_in || !(histogram.total > 0)) return dependence::measure(which, histogram);
  const bool regularised = options.estimator == EntropyEstimator::kJamesStein ||
                           options.estimator == EntropyEstimator::kDirichlet;
  return regularised ? measure_regularised(which, histogram, options)
                     : measure_corrected(which, histogram, options);
}

}  // namespace infuse::study
