#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace infuse::daemon {

/// Installs handlers of SIGSEGV, SIGBUS, SIGILL and SIGFPE that write a note and let the process
/// end by the signal: the signal, the addresses of the calls with the build id of their file, and
/// what was passed to `remember_report` last. Replaces an earlier file. Called once, before other
/// threads are started or while they cannot crash; a path longer than 4095 bytes is ignored.
void install_crash_handler(const std::filesystem::path& file);

/// Gives the calling thread a stack for the handlers, until it ends, so that a note is written
/// where its own stack has overflowed. `install_crash_handler` does so for its thread.
void use_crash_stack();

/// Writes the note of this process; async-signal-safe. Does nothing before `install_crash_handler`.
void write_crash_note(int signal);

/// Keeps a text for the note, shortened to 4 KB; from one thread.
void remember_report(std::string_view text);

/// Moves the note of an earlier run to crash-NAME.txt beside it and removes all but the newest 8.
/// Returns its first line and where it is; nothing if there is none.
std::optional<std::string> keep_crash_note(const std::filesystem::path& file,
                                           const std::string& name);

}  // namespace infuse::daemon
