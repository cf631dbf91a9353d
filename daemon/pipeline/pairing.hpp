#pragma once

#include <algorithm>

#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// Maximum time from an exposure to the span of the sweep that it is matched with.
inline constexpr Duration kMaxPairingGap{50'000'000};

/// True if an exposure is before the end of a sweep. The end itself belongs to the next sweep,
/// unless the sweep has no span.
inline bool is_before_end(Stamp exposure, const Sweep& sweep) {
  const Stamp end = sweep.stamp + sweep.span;
  return exposure < end || (exposure == end && sweep.span == Duration::zero());
}

/// Returns the time from an exposure to a sweep: zero within the sweep's span, otherwise to its
/// nearer end. An image is matched with the sweep for which this is least.
inline Duration pairing_gap(Stamp exposure, const Sweep& sweep) {
  if (exposure < sweep.stamp) return sweep.stamp - exposure;
  if (is_before_end(exposure, sweep)) return Duration::zero();
  return std::max(exposure - (sweep.stamp + sweep.span), Duration(1));
}

}  // namespace infuse::daemon
