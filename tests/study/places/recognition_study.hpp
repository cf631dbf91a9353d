#pragma once

#include <iosfwd>
#include <string>

namespace infuse::study {

/// Recognition across seasons, P 5.3.
struct RecognitionOptions {
  std::string map;            ///< street map, Altfeld
  uint64_t world_seed = 71;   ///< of the town that is tested
  uint64_t learn_seed = 171;  ///< of the town of which the codebook is learned
  double map_spacing = 8;     ///< m between places of the map
  double query_spacing = 16;  ///< m between queries
  double tolerance = 5;       ///< m, of a right place
  size_t words = 300;         ///< of SIFT
  size_t refined = 6;         ///< places per query whose alignment is refined
};

/// Renders the map in winter and queries in winter again (a control) and in four other seasons, of
/// which more than 30 % are off the map, and prints area under the precision–recall curve and
/// recall at full precision of the feature sets of P 5.3.1 by total mutual information P(5.6), of
/// bag of words, Scan Context and of the product's comparison of shapes. Throws std::runtime_error.
void study_recognition(std::ostream& out, const RecognitionOptions& options);

}  // namespace infuse::study
