#include "fusion/streetmap/null_test.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {

NullTest::NullTest(int window) : entries_(static_cast<size_t>(window)) {}

void NullTest::add(double score, std::span<const double> null) {
  Entry entry;
  double sum = 0, squares = 0;
  for (const double value : null) {
    entry.reached += value >= score;
    sum += value;
    squares += value * value;
  }
  const auto n = static_cast<double>(null.size());
  const double deviation = std::sqrt(std::max(squares / n - sum * sum / (n * n), 1e-12));
  entry.draws = static_cast<int>(null.size());
  entry.excess = (score - sum / n) / deviation;
  entries_[updates_++ % entries_.size()] = entry;
}

double NullTest::p_value() const {
  double reached = 1, draws = 1;
  for (const Entry& entry : entries_) {
    reached += entry.reached;
    draws += entry.draws;
  }
  return reached / draws;
}

double NullTest::excess() const {
  const size_t count = std::min(updates_, entries_.size());
  double sum = 0;
  for (const Entry& entry : entries_) sum += entry.excess;
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

void NullTest::clear() {
  std::fill(entries_.begin(), entries_.end(), Entry{});
  updates_ = 0;
}

}  // namespace infuse::streetmap
