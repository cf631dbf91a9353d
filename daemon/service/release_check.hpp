#pragma once

#include <filesystem>
#include <iosfwd>

#include "daemon/command_line/exit_code.hpp"
#include "daemon/config/config.hpp"

namespace infuse::daemon {

/// Tests this release against a configuration and a state directory, before it replaces another
/// one: sets up the sensors, opens the maps, reads the state files and their versions, writes to
/// the state directory, and decodes generated packets through the pipeline. Changes nothing, and
/// needs neither sensors nor the daemon's sockets.
///
/// Prints a line for each step. Returns kDone, kFailure (a step failed, or a state file is of a
/// newer release, which this one would set aside), kUsage (configuration) or kUnreadable (a file),
/// of the first step that failed. `state` empty: the state is left out.
ExitCode self_test(const Config& config, const std::filesystem::path& state, std::ostream& out);

/// The same for one file of the state, with a member "form". `form`: the newest version that this
/// release reads; `damage`: what its parser says, empty if it can be read.
ExitCode test_state_file(const std::filesystem::path& file, int form, const std::string& damage,
                         std::ostream& out);

/// Decodes generated turns of one lidar of every maker through the threads of a pipeline. Returns
/// what is wrong.
Result<void> decode_generated_turns();

}  // namespace infuse::daemon
