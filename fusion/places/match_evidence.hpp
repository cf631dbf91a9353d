#pragma once

#include "fusion/places/sequence_match.hpp"

namespace infuse::places {

/// Margins without a right place: those of the images of a drive in reverse order, in which they
/// follow no path through the map.
class MatchEvidence {
 public:
  /// `similarity` and `options` as for `match_sequences`.
  MatchEvidence(const SimilarityTable& similarity, const SequenceMatchOptions& options);

  /// `by_chance` are the matches of the images in reverse order, by sequences of `length`.
  MatchEvidence(const std::vector<SequenceMatch>& by_chance, size_t length);

  /// Probability that each match of the drive is one by chance, so that no place within the
  /// neighbourhood of its answer is right. The margins are a mixture of those by chance and of a
  /// normal distribution, whose share, mean and spread are the most likely ones (two groups, Efron
  /// 2008; by expectation and maximisation). Those by chance have a Gumbel distribution (the
  /// greatest of many paths) with the mean and spread of the reverse order. Neighbouring sequences
  /// share images: the spread is that of so many as do not overlap, enlarged by its own
  /// uncertainty; 1 with fewer than three of them. A margin below the mean of those by chance
  /// counts as one at it.
  std::vector<double> chances(const std::vector<SequenceMatch>& matches) const;

  /// Gumbel distribution.
  struct Chance {
    double mean = 0, spread = 0;  ///< spread 0: unknown
    double density(double value) const;
  };

 private:
  Chance margin_;
};

}  // namespace infuse::places
