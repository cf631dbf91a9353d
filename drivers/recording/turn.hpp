#pragma once

#include "drivers/measurement/sweep.hpp"

namespace infuse::recording {

/// How the lidar of decoded sweeps turns. A sweep is one turn at constant rate, so that the time of
/// a return follows from its azimuth and the times at which the turn begins and ends.
struct Turn {
  bool clockwise = true;  ///< seen from above
  double cut_deg = 180;   ///< azimuth at which the turn begins and ends, counter-clockwise from x

  bool operator==(const Turn&) const = default;
};

/// Sets the time of each return from its azimuth: the turn begins at `sweep.stamp` and takes
/// `sweep.span`, which must be positive. Times are whole microseconds, so that they do not depend
/// on the processor.
void assign_turn_times(const Turn& turn, Sweep& sweep);

/// States that the source has deskewed the sweep: all returns have the time of its middle.
void assign_middle_time(Sweep& sweep);

}  // namespace infuse::recording
