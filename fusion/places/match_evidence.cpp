#include "fusion/places/match_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace infuse::places {
namespace {

/// Fewest sequences that do not overlap that have a spread by definition.
constexpr double kMinSequences = 2;
/// Standard deviations of an estimate of the spread from n sequences, as a share of it: about
/// 1 / sqrt(2 n) for a normal distribution, twice that and more for the tail of greatest values
/// (decision 17).
constexpr double kSpreadError = 2;

MatchEvidence::Chance chance_of(const std::vector<double>& values, double sequences) {
  const auto n = static_cast<double>(values.size());
  MatchEvidence::Chance out;
  if (values.empty() || sequences < kMinSequences) return out;
  double mean = 0, square = 0;
  for (const double value : values) mean += value / n;
  for (const double value : values) square += (value - mean) * (value - mean) / n;
  out.mean = mean;
  out.spread = std::sqrt(square) * (1 + kSpreadError / std::sqrt(sequences));
  return out;
}

SimilarityTable in_reverse(const SimilarityTable& similarity) {
  SimilarityTable out{similarity.queries, similarity.places, {}};
  out.values.reserve(similarity.values.size());
  for (size_t i = similarity.queries; i-- > 0;) {
    for (size_t j = 0; j < similarity.places; ++j) out.values.push_back(similarity.at(i, j));
  }
  return out;
}

}  // namespace

double MatchEvidence::Chance::exceeded(double value) const {
  if (!(spread > 0) || !std::isfinite(value)) return 1;
  // The greatest of many: Gumbel, by its mean and standard deviation.
  const double z = (value - mean) / spread * std::numbers::pi / std::sqrt(6.0);
  return -std::expm1(-std::exp(-(z + std::numbers::egamma)));
}

MatchEvidence::MatchEvidence(const SimilarityTable& similarity, const SequenceMatchOptions& options)
    : MatchEvidence(match_sequences(in_reverse(similarity), options), options.length) {}

MatchEvidence::MatchEvidence(const std::vector<SequenceMatch>& by_chance, size_t length) {
  std::vector<double> scores, margins;
  for (const SequenceMatch& match : by_chance) {
    if (!std::isfinite(match.score) || !std::isfinite(match.margin)) continue;
    scores.push_back(match.score);
    margins.push_back(match.margin);
  }
  const double sequences = static_cast<double>(scores.size()) / static_cast<double>(length);
  score_ = chance_of(scores, sequences);
  margin_ = chance_of(margins, sequences);
}

double MatchEvidence::chance(const SequenceMatch& match) const {
  return std::max(score_.exceeded(match.score), margin_.exceeded(match.margin));
}

}  // namespace infuse::places
