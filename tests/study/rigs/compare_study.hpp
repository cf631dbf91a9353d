#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tests/study/rigs/rig_recording.hpp"

namespace infuse::study {

/// Counts of comparisons of two extrinsics of rigs drawn at random.
struct CompareCounts {
  static constexpr std::array kDegreesWorse{0.1, 0.3, 1.0};
  struct Count {
    int trials = 0;
    int named_right = 0;  ///< the better one named, p < 0.05
    int named_wrong = 0;  ///< the worse one named
  };
  std::array<Count, 3> worse{};  ///< the truth against a pose that is so far turned
  int equal_trials = 0;          ///< two poses as far from the truth, to opposite sides
  int equal_named = 0;           ///< one of them named
  int unusable = 0;              ///< nothing could be said

  /// A table for a document.
  std::string text() const;
};

/// Compares poses on all diverse scenes of a recording, from a seed.
void compare_on(const RigRecording& recording, uint64_t seed, CompareCounts& counts);

}  // namespace infuse::study
