#include "fusion/places/sequence_match.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace infuse::places {
namespace {

/// Subtracts from `count` values, `stride` apart, their mean and divides by their deviation.
void standardise(float* values, size_t count, size_t stride) {
  double sum = 0, square = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto value = static_cast<double>(values[i * stride]);
    sum += value;
    square += value * value;
  }
  const double mean = sum / static_cast<double>(count);
  const double variance = square / static_cast<double>(count) - mean * mean;
  const double scale = variance > 1e-12 ? 1 / std::sqrt(variance) : 0;
  for (size_t i = 0; i < count; ++i) {
    float& value = values[i * stride];
    value = static_cast<float>((static_cast<double>(value) - mean) * scale);
  }
}

/// Best path through the rows `begin` … `end` - 1 for each place of row `middle`.
std::vector<float> scores_of(const SimilarityTable& table, size_t begin, size_t middle, size_t end,
                             const SequenceMatchOptions& options) {
  const auto penalty = static_cast<float>(options.step_penalty);
  const auto none = -std::numeric_limits<float>::infinity();
  // The best sum of the rows from an end up to, and with, each place of the row that is reached.
  const auto reach = [&](size_t from, ptrdiff_t direction) {
    std::vector<float> sum(table.places), next(table.places);
    for (size_t j = 0; j < table.places; ++j) sum[j] = table.at(from, j);
    for (size_t row = from; row != middle;) {
      row = static_cast<size_t>(static_cast<ptrdiff_t>(row) + direction);
      for (size_t j = 0; j < table.places; ++j) {
        float best = none;
        for (size_t step = 0; step <= options.max_step; ++step) {
          const ptrdiff_t before =
              static_cast<ptrdiff_t>(j) - direction * static_cast<ptrdiff_t>(step);
          if (before < 0 || before >= static_cast<ptrdiff_t>(table.places)) break;
          const float dear = step == 1 ? 0 : penalty;
          best = std::max(best, sum[static_cast<size_t>(before)] - dear);
        }
        next[j] = best + table.at(row, j);
      }
      std::swap(sum, next);
    }
    return sum;
  };
  std::vector<float> before = reach(begin, 1);
  const std::vector<float> after = reach(end - 1, -1);
  for (size_t j = 0; j < table.places; ++j) {
    before[j] = (before[j] + after[j] - table.at(middle, j)) / static_cast<float>(end - begin);
  }
  return before;
}

}  // namespace

std::optional<std::string> SequenceMatchOptions::invalid() const {
  if (length == 0) return "length must be at least 1";
  if (max_step == 0) return "max_step must be at least 1";
  if (!(step_penalty >= 0)) return "step_penalty must not be negative";
  return std::nullopt;
}

std::vector<SequenceMatch> match_sequences(const SimilarityTable& similarity,
                                           const SequenceMatchOptions& options) {
  std::vector<SequenceMatch> out(similarity.queries);
  if (similarity.places == 0) return out;
  SimilarityTable table = similarity;
  for (size_t i = 0; i < table.queries; ++i) standardise(&table.at(i, 0), table.places, 1);
  for (size_t j = 0; j < table.places; ++j)
    standardise(&table.at(0, j), table.queries, table.places);
  const size_t length = std::min(options.length, table.queries);
  for (size_t query = 0; query < table.queries; ++query) {
    const size_t half = length / 2;
    const size_t begin = std::min(query > half ? query - half : 0, table.queries - length);
    const auto scores = scores_of(table, begin, query, begin + length, options);
    const auto best = std::max_element(scores.begin(), scores.end());
    SequenceMatch& match = out[query];
    match.place = static_cast<size_t>(best - scores.begin());
    match.score = static_cast<double>(*best);
    double other = -std::numeric_limits<double>::infinity();
    match.runner_up = match.place;
    for (size_t j = 0; j < scores.size(); ++j) {
      const size_t distance = j > match.place ? j - match.place : match.place - j;
      if (distance <= options.neighbourhood || static_cast<double>(scores[j]) <= other) continue;
      other = static_cast<double>(scores[j]);
      match.runner_up = j;
    }
    match.margin = std::isfinite(other) ? match.score - other : 0;
  }
  return out;
}

}  // namespace infuse::places
