#pragma once

namespace infuse::daemon {

/// Names the calling thread and keeps it on a core, if this process may use that core and another
/// one besides. Otherwise it stays where the kernel puts it.
void name_and_pin(const char* name, int core);

/// Gives the calling thread real-time priority (SCHED_FIFO); false where that is not permitted.
bool make_real_time(int priority);

/// Keeps this process's memory from being swapped out; false where that is not permitted.
bool lock_memory();

}  // namespace infuse::daemon
