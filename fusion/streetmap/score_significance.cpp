#include "fusion/streetmap/score_significance.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {

ScoreSignificance::ScoreSignificance(int window) : entries_(static_cast<size_t>(window)) {}

void ScoreSignificance::add(double score, std::span<const double> null) {
  Entry entry;
  double sum = 0, squares = 0;
  for (const double value : null) {
    entry.exceedances += value >= score;
    sum += value;
    squares += value * value;
  }
  const auto n = static_cast<double>(null.size());
  const double sigma = std::sqrt(std::max(squares / n - sum * sum / (n * n), 1e-12));
  entry.draws = static_cast<int>(null.size());
  entry.z_score = (score - sum / n) / sigma;
  entries_[updates_++ % entries_.size()] = entry;
}

double ScoreSignificance::p_value() const {
  double reached = 1, draws = 1;
  for (const Entry& entry : entries_) {
    reached += entry.exceedances;
    draws += entry.draws;
  }
  return reached / draws;
}

double ScoreSignificance::mean_z_score() const {
  const size_t count = std::min(updates_, entries_.size());
  double sum = 0;
  for (const Entry& entry : entries_) sum += entry.z_score;
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

void ScoreSignificance::clear() {
  std::fill(entries_.begin(), entries_.end(), Entry{});
  updates_ = 0;
}

}  // namespace infuse::streetmap
