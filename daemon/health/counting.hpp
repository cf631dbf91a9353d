#pragma once

#include <cstdint>

namespace infuse::daemon {

/// Returns the growth of a counter. It may step back by a few when a late packet arrives after all.
inline uint64_t increase(uint64_t now, uint64_t before) { return now > before ? now - before : 0; }

/// Returns the fraction of what was lost; 0 without anything.
inline double lost_fraction(uint64_t lost, uint64_t received) {
  const uint64_t all = lost + received;
  return all == 0 ? 0 : static_cast<double>(lost) / static_cast<double>(all);
}

}  // namespace infuse::daemon
