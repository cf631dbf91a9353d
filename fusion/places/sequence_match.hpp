#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace infuse::places {

/// Similarities of the images of a query drive (rows) to those of a map (columns).
struct SimilarityTable {
  size_t queries = 0, places = 0;
  std::vector<float> values;  ///< row by row

  float& at(size_t query, size_t place) { return values[query * places + place]; }
  float at(size_t query, size_t place) const { return values[query * places + place]; }
};

/// Settings of the matching of sequences.
struct SequenceMatchOptions {
  size_t length = 21;         ///< images of the query that are matched together
  size_t max_step = 3;        ///< places of the map between one image of the query and the next
  double step_penalty = 0.1;  ///< standard deviations, cost of a step other than one place
  size_t neighbourhood = 10;  ///< places beside the best that are not another answer

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Where an image of the query is on the map.
struct SequenceMatch {
  size_t place = 0;      ///< of the image in the middle of the sequence
  double score = 0;      ///< mean similarity along the path, in standard deviations
  double margin = 0;     ///< by which the best path elsewhere scores lower …
  size_t runner_up = 0;  ///< … and its place; `place` if there is none
};

/// Finds each image of the query by the sequence about it (P 6.2.3: sequences find what single
/// images cannot): the path through the map that is most similar, forwards by 0 to `max_step`
/// places an image, so that neither equal speed nor equal spacing is assumed; by dynamic
/// programming. Similarities are first compared with their row and column. At the ends of the
/// drive the sequence is not centred. One answer per query. `options.invalid()` must be empty.
std::vector<SequenceMatch> match_sequences(const SimilarityTable& similarity,
                                           const SequenceMatchOptions& options = {});

}  // namespace infuse::places
