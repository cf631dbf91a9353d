#include "drivers/recording/turn.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/measurement/fast_atan2.hpp"

namespace infuse::recording {

void assign_turn_times(const Turn& turn, Sweep& sweep) {
  const double direction = (turn.clockwise ? -1 : 1) / (2 * std::numbers::pi);
  const double cut_direction = (turn.clockwise ? 1.0 : -1.0) / 360;
  const bool by_ring = sweep.rings > 0 && turn.ring_cuts_deg.size() == sweep.rings;
  const double span_us = static_cast<double>(sweep.span.count()) * 1e-3;
  for (size_t i = 0; i < sweep.size(); ++i) {
    const double azimuth =
        fast_atan2(static_cast<double>(sweep.y[i]), static_cast<double>(sweep.x[i]));
    const double cut_deg = by_ring ? turn.ring_cuts_deg[sweep.ring[i]] : turn.cut_deg;
    const double turns = direction * azimuth + cut_direction * cut_deg;
    const double fraction = turns - std::floor(turns);
    sweep.time_offset_ns[i] = 1000 * static_cast<int32_t>(fraction * span_us);
  }
  sweep.has_times = true;
}

void assign_middle_time(Sweep& sweep) {
  std::fill(sweep.time_offset_ns.begin(), sweep.time_offset_ns.end(),
            static_cast<int32_t>(sweep.span.count() / 2));
  sweep.has_times = true;
  sweep.deskewed = true;
}

}  // namespace infuse::recording
