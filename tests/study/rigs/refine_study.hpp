#pragma once

#include <cstdint>
#include <ostream>

#include "tests/study/rigs/rig_recording.hpp"

namespace infuse::study {

/// Counts of refinements of wrong intrinsics.
struct RefineCounts {
  int trials = 0;
  int refined = 0;
  int usable = 0;  ///< refined, with a usable pose
  int within = 0;  ///< refined and within 0.5 % of the focal length, 2 px and 0.01 of k1
  int inside = 0;  ///< refined and inside the 95 % region of the stated covariance
};

/// States the intrinsics of a recording wrong, by up to 2 %, 8 px and 0.03, calibrates with
/// `calibrate_with_intrinsics` on all diverse scenes, and writes one row.
void refine_on(const RigRecording& recording, uint64_t seed, std::ostream& out,
               RefineCounts& counts);

}  // namespace infuse::study
