#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tests/study/rigs/rig_recording.hpp"

namespace infuse::study {

/// Counts of comparisons of two extrinsics of rigs drawn at random.
struct CompareCounts {
  static constexpr std::array kDegreesWorse{0.1, 0.3, 1.0};
  static constexpr std::array kBiases{0.0, 0.5};  ///< px, CompareOptions::bias
  struct Count {
    int trials = 0;
    std::array<int, kBiases.size()> named_right{};  ///< the better one named, p < 0.05
    std::array<int, kBiases.size()> named_wrong{};  ///< the worse one named
  };
  std::array<Count, 3> worse{};  ///< the truth against a pose that is so far turned
  Count equal;  ///< two poses as far from the truth, to opposite sides; which is named has no sense
  int unusable = 0;  ///< nothing could be said

  /// A table for a document.
  std::string text() const;
};

/// Compares poses on all diverse scenes of a recording, from a seed.
void compare_on(const RigRecording& recording, uint64_t seed, CompareCounts& counts);

}  // namespace infuse::study
