#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace infuse::streetmap {

/// Compares scores with their null distribution over the last updates. Each update adds the score
/// of the estimate and the scores of displaced poses; the p-value is the share of displaced poses
/// that reach the score of the estimate.
class ScoreSignificance {
 public:
  /// `window`: number of updates that count.
  explicit ScoreSignificance(int window);

  /// Adds an update: `score` of the estimate, `null` of displaced poses (not empty).
  void add(double score, std::span<const double> null);

  /// (1 + null scores that reach the score of their update) / (1 + all null scores) of the window;
  /// 1 before the first update.
  double p_value() const;

  /// Mean over the window of (score − mean of null) / standard deviation of null.
  double mean_z_score() const;

  /// True once the window is full.
  bool window_full() const { return updates_ >= entries_.size(); }

  void clear();

 private:
  struct Entry {
    int exceedances = 0;
    int draws = 0;
    double z_score = 0;
  };
  std::vector<Entry> entries_;
  size_t updates_ = 0;
};

}  // namespace infuse::streetmap
