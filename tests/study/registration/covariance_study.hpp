#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace infuse::study {

/// Errors of GICP in units of its stated covariance.
struct NormalisedErrors {
  /// Squared error in the information that was stated, per determined direction; usable results.
  std::vector<double> values;
  size_t unusable = 0;
  size_t with_free_directions = 0;
  /// Root mean squares of the errors and of the stated standard deviations.
  double translation = 0, stated_translation = 0;  ///< m
  double rotation = 0, stated_rotation = 0;        ///< rad

  std::string text() const;
};

/// Aligns neighbouring sweeps of simulated drives through towns drawn from `first_seed` and on, ten
/// pairs 0.5 to 3.5 m apart each, from guesses drawn about the truth. Throws std::runtime_error.
NormalisedErrors normalised_errors(uint64_t first_seed, int drives);

}  // namespace infuse::study
