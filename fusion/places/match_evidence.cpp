#include "fusion/places/match_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace infuse::places {
namespace {

/// Minimum number of sequences that do not overlap. Of pure noise 4 % is found with 2 of them, 0.8
/// % with 3 (decision 17).
constexpr double kMinSequences = 3;
/// Standard deviation of an estimate of the spread from n sequences, as a share of it, times
/// sqrt(n): 1 / sqrt(2) for a normal distribution, more for the tail of greatest values (decision
/// 17).
constexpr double kSpreadError = 1;
constexpr int kIterations = 100;  // of expectation and maximisation; bounds time

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

/// Normal distribution of the margins of what is right.
struct Right {
  double share = 0, mean = 0, spread = 0;

  /// The most likely one if each match is by chance with its probability of `by_chance`; false if
  /// nothing is right.
  bool fit(const std::vector<SequenceMatch>& matches, const std::vector<double>& by_chance,
           const MatchEvidence::Chance& chance) {
    double sum = 0, first = 0, second = 0;
    for (size_t i = 0; i < matches.size(); ++i) {
      sum += 1 - by_chance[i];
      first += (1 - by_chance[i]) * matches[i].margin;
    }
    share = 0;
    if (!(sum > 0)) return false;
    share = (sum + 1) / (static_cast<double>(matches.size()) + 2);  // Laplace's rule
    // What is right leads by more than chance does.
    mean = std::max(first / sum, chance.mean + chance.spread);
    for (size_t i = 0; i < matches.size(); ++i)
      second += (1 - by_chance[i]) * (matches[i].margin - mean) * (matches[i].margin - mean);
    spread = std::max(std::sqrt(second / sum), chance.spread / 2);
    return true;
  }

  /// Probability that a match of this margin is one by chance.
  double chance(double margin, const MatchEvidence::Chance& by_chance) const {
    const double z = (margin - mean) / spread;
    const double of_right =
        share * std::exp(-z * z / 2) / (spread * std::sqrt(2 * std::numbers::pi));
    const double of_chance = (1 - share) * by_chance.density(margin);
    // Far from both, where both vanish, by the side.
    if (!(of_right + of_chance > 0)) return margin > mean ? 0 : 1;
    return of_chance / (of_right + of_chance);
  }
};

}  // namespace

double MatchEvidence::Chance::density(double value) const {
  const double per_unit = std::numbers::pi / (std::sqrt(6.0) * spread);
  const double z = (value - mean) * per_unit + std::numbers::egamma;
  return per_unit * std::exp(-z - std::exp(-z));
}

MatchEvidence::MatchEvidence(const SimilarityTable& similarity, const SequenceMatchOptions& options)
    : MatchEvidence(match_sequences(in_reverse(similarity), options), options.length) {}

MatchEvidence::MatchEvidence(const std::vector<SequenceMatch>& by_chance, size_t length) {
  std::vector<double> margins;
  for (const SequenceMatch& match : by_chance) {
    if (std::isfinite(match.margin)) margins.push_back(match.margin);
  }
  const double sequences = static_cast<double>(margins.size()) / static_cast<double>(length);
  margin_ = chance_of(margins, sequences);
}

std::vector<double> MatchEvidence::chances(const std::vector<SequenceMatch>& matches) const {
  std::vector<double> out(matches.size(), 1);
  const bool finite = std::all_of(matches.begin(), matches.end(), [](const SequenceMatch& match) {
    return std::isfinite(match.margin);
  });
  if (!finite || !(margin_.spread > 0)) return out;
  // It begins with what few lead by through chance.
  for (size_t i = 0; i < matches.size(); ++i)
    out[i] = matches[i].margin > margin_.mean + 2 * margin_.spread ? 0 : 1;
  Right right;
  for (int iteration = 0; iteration < kIterations && right.fit(matches, out, margin_);
       ++iteration) {
    for (size_t i = 0; i < matches.size(); ++i) out[i] = right.chance(matches[i].margin, margin_);
  }
  // Below the mean by chance the wider distribution would exceed that by chance again: what is
  // stated of such a margin is what holds at the mean.
  for (size_t i = 0; right.share > 0 && i < matches.size(); ++i)
    out[i] = right.chance(std::max(matches[i].margin, margin_.mean), margin_);
  // In the tail of the wider distribution too a greater margin is no less probable.
  std::vector<size_t> order(matches.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return matches[a].margin < matches[b].margin; });
  for (size_t k = 1; k < order.size(); ++k)
    out[order[k]] = std::min(out[order[k]], out[order[k - 1]]);
  return out;
}

}  // namespace infuse::places
