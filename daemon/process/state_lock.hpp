#pragma once

#include <filesystem>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Takes a state directory for this process, until the result is gone: two daemons that share one
/// would destroy each other's files. Works on a read-only disk; a folder that is not there is
/// nothing to share. Errors: another process has it.
Result<host::FileDescriptor> lock_state(const std::filesystem::path& folder);

}  // namespace infuse::daemon
