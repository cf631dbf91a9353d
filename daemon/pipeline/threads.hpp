#pragma once

namespace infuse::daemon {

/// Names the calling thread and keeps it on a core, if this process may use that core and another
/// one besides. Otherwise it stays where the kernel puts it.
void name_and_pin(const char* name, int core);

}  // namespace infuse::daemon
