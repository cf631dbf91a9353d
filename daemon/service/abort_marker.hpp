#pragma once

#include <filesystem>

namespace infuse::daemon {

/// From now on a process that is aborted from outside (SIGABRT of another process), as the service
/// manager's watchdog does with one that is stuck, leaves an empty file behind before it ends.
/// Replaces what was requested before; a path that is too long (4096 bytes) is passed over.
void install_abort_handler(const std::filesystem::path& file);

/// Whether there is such a note. It is gone afterwards.
bool consume_abort_marker(const std::filesystem::path& file);

}  // namespace infuse::daemon
