#pragma once

#include <ctime>

namespace infuse::daemon {

/// Returns the processor time of this process, s.
inline double process_cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace infuse::daemon
