#pragma once

#include <pthread.h>
#include <sched.h>

namespace infuse::daemon {

/// Gives a thread only the processor time that nobody else wants.
inline void make_idle(pthread_t thread) {
  const sched_param none{};
  pthread_setschedparam(thread, SCHED_IDLE, &none);
}

/// Gives it its share again, so that who waits for its end does not wait for all other processes.
/// Without privileges this needs RLIMIT_NICE of 20, as the unit has it (sched(7)).
inline void make_ordinary(pthread_t thread) {
  const sched_param none{};
  pthread_setschedparam(thread, SCHED_OTHER, &none);
}

}  // namespace infuse::daemon
