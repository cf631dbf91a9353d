#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace infuse::online {

/// Tail of the evidence distribution for a correct calibration, which determines how often it would
/// reach the limit. Evidence rises from zero and falls back repeatedly; above a few nats the peaks
/// of a sequential test of log-likelihood ratios decay exponentially (Siegmund 1985).
class NullTail {
 public:
  /// Nats above which peaks count: the level of a suspicion (`DriftDetectorOptions::suspect`),
  /// which no single evaluation (`max_evidence_per_evaluation`) exceeds by itself.
  static constexpr double kPeakThreshold = 4;

  /// Adds the evidence after one evaluation.
  void add(double evidence) {
    if (evidence > kPeakThreshold) {
      current_peak_ = std::max(current_peak_, evidence);
    } else {
      end_excursion();
    }
    if (evaluation_counts_.size() < 8) evaluation_counts_.resize(8);
    for (size_t level = 0; level < evaluation_counts_.size(); ++level) {
      evaluation_counts_[level] += evidence >= static_cast<double>(level) ? 1 : 0;
    }
  }
  void end_excursion() {
    if (current_peak_ > 0) peaks_.push_back(current_peak_);
    current_peak_ = 0;
  }

  size_t peak_count() const { return peaks_.size(); }
  /// Fraction of evaluations with at least `level` nats, 0 … 7.
  double fraction_above(size_t level) const {
    return evaluation_counts_.empty() || evaluation_counts_[0] == 0
               ? 0
               : evaluation_counts_[level] / evaluation_counts_[0];
  }

  /// Nats by which the frequency of peaks falls to 1/e: their mean excess, and its upper 95 %
  /// bound.
  double excess_scale() const {
    double sum = 0;
    for (const double peak : peaks_) sum += peak - kPeakThreshold;
    return peaks_.empty() ? 0 : sum / static_cast<double>(peaks_.size());
  }
  double upper_excess_scale() const {
    const auto n = static_cast<double>(std::max<size_t>(peaks_.size(), 3));
    return excess_scale() /
           (1 - 1.645 / std::sqrt(n) + 0.9 / n);  // χ² with 2n degrees of freedom, approximately
  }

  /// Hours between two alarms at a limit, for the given hours driven.
  double hours_between_alarms(double limit, double hours, double scale) const {
    const double peaks_per_hour = static_cast<double>(std::max<size_t>(peaks_.size(), 1)) / hours;
    return std::exp((limit - kPeakThreshold) / std::max(scale, 1e-3)) / peaks_per_hour;
  }

 private:
  std::vector<double> peaks_;
  std::vector<double> evaluation_counts_;  // evaluations with at least that many nats
  double current_peak_ = 0;
};

}  // namespace infuse::online
