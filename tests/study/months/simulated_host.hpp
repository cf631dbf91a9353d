#pragma once

#include "drivers/host/time_base.hpp"

namespace infuse::study {

/// The clocks of the vehicle's computer.
struct SimulatedHost {
  Stamp truth;             ///< the true time
  Stamp booted;            ///< when the monotonic clock was 0
  Duration wall_error{0};  ///< of the wall clock, since `stepped_at`
  Duration wall_error_before{0};
  Stamp stepped_at = Stamp::earliest();

  /// Steps the wall clock in the middle of the second before `truth`.
  void step(Duration by) {
    wall_error_before = wall_error;
    wall_error += by;
    stepped_at = truth - from_seconds(0.4723);
  }

  /// Wall time at a true time.
  Stamp wall_at(Stamp time) const {
    return time + (time < stepped_at ? wall_error_before : wall_error);
  }

  /// Both clocks at a true time.
  host::ClockReading read(Stamp time) const {
    return {(time - booted).count(), wall_at(time).ns()};
  }
};

}  // namespace infuse::study
