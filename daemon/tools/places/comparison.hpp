#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/tools/places/place_list.hpp"
#include "drivers/measurement/error.hpp"
#include "fusion/places/sequence_match.hpp"

namespace infuse::daemon {

/// How two drives are compared.
struct ComparisonRequest {
  std::string places, queries;  ///< drives, captures or folders of images
  std::string camera, lidar;    ///< names, if there are several
  std::string method = "edges";
  std::string sequence = "match";
  size_t length = 21;  ///< places of the query that are matched together
  size_t every = 5;    ///< sweeps from one place to the next
};

/// Where one place of the query was found.
struct PlaceAnswer {
  places::SequenceMatch match;
  std::optional<double> chance;  ///< probability that it is one by chance; of sequences
};

/// Two drives, compared.
struct Comparison {
  PlaceList places, queries;
  std::vector<PlaceAnswer> answers;  ///< one per place of the query
};

/// The values of `method`: "edges", "correlation" and "words" of images, "shape" of sweeps,
/// "total-mi" of sweeps with images if there are any.
const std::vector<std::string>& comparison_methods();

/// The values of `sequence`: "none", "match", "mutual", "directed".
const std::vector<std::string>& sequence_methods();

/// Compares the drives. Errors: those of reading, more than 400 million pairs, a sequence by
/// information of another method than "edges".
Result<Comparison> compare_drives(const ComparisonRequest& request);

}  // namespace infuse::daemon
