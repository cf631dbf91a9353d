#pragma once

#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/trajectory.hpp"

namespace infuse::motion {

/// Sets `motion` (capacity 2 or more, `max_gap` above any span) to a constant twist per second over
/// a sweep; the vehicle is at the identity at `reference`.
inline void set_constant_motion(const Sweep& sweep, Stamp reference,
                                const geometry::Vector6& velocity, geometry::Trajectory& motion) {
  // A firing may lie a little outside the span that the sweep states.
  constexpr Duration kMargin{10'000'000};
  motion.clear();
  for (const Stamp stamp : {sweep.stamp - kMargin, sweep.stamp + sweep.span + kMargin}) {
    motion.append({stamp, geometry::exp(velocity * to_seconds(stamp - reference))});
  }
}

}  // namespace infuse::motion
