#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "tests/study/registration/recorded_scans.hpp"

namespace infuse::study {

/// How often the global guess finds the pose of scans that are turned to any heading.
struct GlobalGuessShare {
  size_t pairs = 0;
  size_t right = 0;         ///< usable, within 0.5 m and 2° of the truth
  size_t wrong = 0;         ///< usable, but not right
  double max_distance = 0;  ///< m, between the scans of a pair

  void operator+=(const GlobalGuessShare& other);
  std::string text() const;
};

/// Tries up to `count` pairs of scans 1 to 10 m apart, drawn with their headings from the seed.
GlobalGuessShare try_global_guess(std::span<const PosedScan> scans, size_t count, uint64_t seed);

/// The same for pairs of simulated drives, seeds `first_seed` and on. Throws std::runtime_error.
GlobalGuessShare try_global_guess_simulated(uint64_t first_seed, int drives);

}  // namespace infuse::study
