#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace infuse::streetmap {

/// Compares scores with what they would be by chance, over the last updates. Each update brings the
/// score of the estimate and scores of poses that cannot be right; the p-value is the share of the
/// latter that reach the former.
class ScoreSignificance {
 public:
  /// `window`: updates that count.
  explicit ScoreSignificance(int window);

  /// Adds an update. `score` is the estimate's, `null` those by chance (not empty).
  void add(double score, std::span<const double> null);

  /// (1 + chance scores that reached their update's) / (1 + all chance scores) of the window; 1
  /// before the first update.
  double p_value() const;

  /// Mean over the window of (score − mean of null) / deviation of null.
  double mean_z_score() const;

  /// Whether the window is full.
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
