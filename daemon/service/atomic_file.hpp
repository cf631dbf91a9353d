#pragma once

#include <filesystem>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Writes a temporary file next to `path`, syncs it and renames it to `path`: a power cut or a full
/// disk at any moment leaves the old or the new file. Readable by the user and the group.
Result<void> write_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace infuse::daemon
