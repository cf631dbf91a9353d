#pragma once

#include <cstdint>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse::lidar {

/// Where and when the beams of a model fire: what a simulator needs of a lidar. During a *firing
/// sequence*, the data that share one azimuth in a packet, each slot fires one beam.
struct BeamPattern {
  struct Slot {
    uint16_t beam = 0;        ///< number of the laser, in the order of the wire
    uint16_t ring = 0;        ///< by elevation from below
    uint16_t column = 0;      ///< number of the firing within the sequence
    int32_t time_ns = 0;      ///< of the firing, after the sequence's start
    double elevation = 0;     ///< rad, above the horizontal
    double azimuth = 0;       ///< rad, clockwise from the sequence's azimuth at the firing
    double right_offset = 0;  ///< m, of the beam's origin across the beam, to the right
    double up_offset = 0;     ///< m, of the beam's origin
  };
  uint16_t beams = 0;
  uint16_t columns = 0;     ///< number of firings in a sequence
  Duration period{0};       ///< from one sequence to the next
  std::vector<Slot> slots;  ///< in the order of the wire
};

}  // namespace infuse::lidar
