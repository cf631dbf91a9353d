#pragma once

#include <vector>

#include "drivers/measurement/sweep.hpp"

namespace infuse::recording {

/// How the lidar of decoded sweeps turns. A sweep is one turn at constant rate, so that the time of
/// a return follows from its azimuth and the times at which the turn begins and ends.
struct Turn {
  bool clockwise = true;  ///< seen from above
  double cut_deg = 180;   ///< azimuth at which the turn begins and ends, counter-clockwise from x
  /// The same of each ring, from below, where the lasers point at different azimuths at one time,
  /// as those of an HDL-64E. Used for sweeps with as many rings; empty: `cut_deg` holds for all.
  std::vector<double> ring_cuts_deg = {};

  bool operator==(const Turn&) const = default;
};

/// Sets the time of each return from its azimuth: the turn begins at `sweep.stamp` and takes
/// `sweep.span`, which must be positive. Times are whole microseconds, so that they do not depend
/// on the processor, and not after the end of the turn.
void assign_turn_times(const Turn& turn, Sweep& sweep);

/// States that the source has deskewed the sweep: all returns have the time of its middle.
void assign_middle_time(Sweep& sweep);

}  // namespace infuse::recording
