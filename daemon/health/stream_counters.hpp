#pragma once

#include <cstdint>

#include "daemon/health/source_state.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Counters of a camera, a bus, an inertial unit or a GNSS receiver since the start, at one moment
/// of drive time. They only grow. Plain data, copied between threads.
struct StreamCounters {
  uint64_t received = 0;      ///< images, bus frames, samples or fixes
  uint64_t used = 0;          ///< of these, passed to fusion
  uint64_t refused = 0;       ///< of these, not readable
  uint64_t lost = 0;          ///< images missing by their number, or without a sweep
  uint64_t out_of_order = 0;  ///< stamps earlier than the one before
  Stamp first;                ///< stamp of the first; valid if received > 0
  Stamp last;                 ///< stamp of the latest; valid if received > 0
  SourceState source;         ///< live: state of its interface or device

  /// Counts one that arrived.
  void count(Stamp stamp) {
    if (received == 0) {
      first = stamp;
    } else if (stamp < last) {
      ++out_of_order;
    }
    last = stamp;
    ++received;
  }
};

}  // namespace infuse::daemon
