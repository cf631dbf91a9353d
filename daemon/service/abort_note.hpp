#pragma once

#include <filesystem>

namespace infuse::daemon {

/// From now on a process that is aborted from outside (SIGABRT of another process), as the service
/// manager's watchdog does with one that is stuck, leaves an empty file behind before it ends.
/// Replaces what was asked for before; a path that is too long (4096 bytes) is passed over.
void leave_note_on_abort(const std::filesystem::path& file);

/// Whether there is such a note. It is gone afterwards.
bool take_abort_note(const std::filesystem::path& file);

}  // namespace infuse::daemon
