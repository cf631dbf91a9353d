#pragma once

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Time of a test, seconds after its start.
inline Stamp at(double seconds) {
  return Stamp::from_ns(1'700'000'000'000'000'000) + from_seconds(seconds);
}

}  // namespace infuse
