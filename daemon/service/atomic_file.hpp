#pragma once

#include <filesystem>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Writes a file beside `path`, brings it to the disk and puts it in its place: a power cut or a
/// full disk at any moment leaves the old or the new file. Readable by the user and the group.
Result<void> write_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace infuse::daemon
