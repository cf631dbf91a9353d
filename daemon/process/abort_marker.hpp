#pragma once

#include <filesystem>

namespace infuse::daemon {

/// Installs a handler that leaves an empty file behind when another process aborts this one
/// (SIGABRT), as the service manager's watchdog does with a stuck daemon, and a crash note at every
/// abort. Replaces an earlier
/// handler; a path longer than 4095 bytes is ignored.
void install_abort_handler(const std::filesystem::path& file);

/// Removes the marker file. Returns true if there was one.
bool consume_abort_marker(const std::filesystem::path& file);

}  // namespace infuse::daemon
