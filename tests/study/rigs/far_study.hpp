#pragma once

#include <cstdint>
#include <ostream>

#include "tests/study/rigs/rig_recording.hpp"

namespace infuse::study {

/// Counts of calibrations from far initial poses.
struct FarCounts {
  int trials = 0;
  int right = 0;  ///< within 0.2 degrees and 5 cm of the truth
  int usable = 0;
  int surely_wrong = 0;  ///< `RigTrial::surely_wrong`
};

/// How far initial poses are drawn from the truth.
enum class FarStart {
  kTenDegrees,  ///< 10 degrees about and 8 cm along each axis; searched within 10 degrees
  kAnyHeading,  ///< any heading, 10 degrees out of upright, 30 cm along each axis
};

/// Calibrates on all diverse scenes of a recording from a far initial pose, and writes one row.
void start_far(const RigRecording& recording, uint64_t seed, FarStart start, std::ostream& out,
               FarCounts& counts);

}  // namespace infuse::study
