#pragma once

#include "fusion/places/sequence_match.hpp"

namespace infuse::places {

/// What the matches of a drive score by chance: those of its images in reverse order, in which they
/// follow no path through the map.
class MatchEvidence {
 public:
  /// `similarity` and `options` as for `match_sequences`.
  MatchEvidence(const SimilarityTable& similarity, const SequenceMatchOptions& options);

  /// `by_chance` are the matches of the images in reverse order, by sequences of `length`.
  MatchEvidence(const std::vector<SequenceMatch>& by_chance, size_t length);

  /// Probability that a match scores as high, or leads by as much, by chance, the larger of the
  /// two: tails of Gumbel distributions (the greatest of many paths) with the mean and spread of
  /// the chance matches. Neighbouring sequences share images: the spread is that of so many as do
  /// not overlap, enlarged by its own uncertainty; 1 with fewer than two of them. Conservative: in
  /// reverse order too a path may stay near the right place for some images.
  double chance(const SequenceMatch& match) const;

  /// Distribution of a quantity by chance.
  struct Chance {
    double mean = 0, spread = 0;  ///< spread 0: unknown
    double exceeded(double value) const;
  };

 private:
  Chance score_, margin_;
};

}  // namespace infuse::places
