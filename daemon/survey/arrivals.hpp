#pragma once

#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// When the messages of one kind came.
struct Arrivals {
  uint64_t count = 0;
  Stamp first, last;        ///< meaningful when count > 0
  Duration longest_gap{0};  ///< between two in a row
  Stamp longest_gap_at;     ///< when it began
  uint64_t backward = 0;    ///< came with a stamp before that of the one before

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

  /// First to last.
  Duration span() const { return last - first; }

  /// Messages a second; 0 where there are fewer than two.
  double rate_hz() const {
    const double seconds = to_seconds(span());
    return count < 2 || seconds <= 0 ? 0 : static_cast<double>(count - 1) / seconds;
  }
};

}  // namespace infuse::daemon
