#pragma once

namespace infuse::daemon {

/// Names the calling thread, gives it a stack for crash notes, and pins it to a core if the process
/// may use that core and at least one other.
void name_and_pin(const char* name, int core);

/// Gives the calling thread real-time priority (SCHED_FIFO). Returns false without permission.
bool make_real_time(int priority);

/// Locks the memory of the process (mlockall). Returns false without permission.
bool lock_memory();

}  // namespace infuse::daemon
