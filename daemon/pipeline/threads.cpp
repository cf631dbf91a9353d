#include "daemon/pipeline/threads.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include "daemon/process/crash_note.hpp"

namespace infuse::daemon {

void name_and_pin(const char* name, int core) {
  pthread_setname_np(pthread_self(), name);
  use_crash_stack();
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return;
  if (!CPU_ISSET(core, &allowed) || CPU_COUNT(&allowed) < 2) return;
  cpu_set_t wanted;
  CPU_ZERO(&wanted);
  CPU_SET(core, &wanted);
  pthread_setaffinity_np(pthread_self(), sizeof(wanted), &wanted);
}

bool make_real_time(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

bool lock_memory() { return mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0; }

}  // namespace infuse::daemon
