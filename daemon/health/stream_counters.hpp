#pragma once

#include <cstdint>

#include "daemon/health/source_state.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What a camera, a bus, an inertial unit or a receiver has delivered since the start, at one
/// moment of drive time. Every number only grows. Plain data: it crosses threads by copy.
struct StreamCounters {
  uint64_t received = 0;      ///< pictures, lines of a bus, samples or fixes
  uint64_t used = 0;          ///< of these, what fusion was given: pictures, samples of the vehicle
  uint64_t refused = 0;       ///< of these, what could not be read
  uint64_t lost = 0;          ///< pictures missing by their number, or for which no sweep came
  uint64_t out_of_order = 0;  ///< stamps that lay before the one above
  Stamp first;                ///< stamp of the first; meaningful when received > 0
  Stamp last;                 ///< and of the latest
  SourceState source;         ///< live: of its interface or device

  /// One more arrived.
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
