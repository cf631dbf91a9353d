#pragma once

#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::makers {

/// Arrival statistics of the messages of one kind.
struct Arrivals {
  uint64_t count = 0;
  Stamp first, last;        ///< valid if count > 0
  Duration longest_gap{0};  ///< between two consecutive messages
  Stamp longest_gap_at;     ///< start of the longest gap
  uint64_t backward = 0;    ///< number of messages with a stamp before that of the previous one

  void add(Stamp stamp) {
    if (count++ == 0) first = last = stamp;
    const Duration gap = stamp - last;
    if (gap > longest_gap) {
      longest_gap = gap;
      longest_gap_at = last;
    }
    if (gap < Duration::zero()) {
      ++backward;
    } else {
      last = stamp;
    }
  }

  /// Time from the first message to the last.
  Duration span() const { return last - first; }

  /// Messages per second; 0 if there are fewer than two.
  double rate_hz() const {
    const double seconds = to_seconds(span());
    return count < 2 || seconds <= 0 ? 0 : static_cast<double>(count - 1) / seconds;
  }
};

}  // namespace infuse::makers
