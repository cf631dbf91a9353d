#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// Writes a temporary file beside `path`, flushes it to the disk and renames it to `path`: readers,
/// a power cut or a full disk at any moment find the old or the new file, complete. Only a regular
/// file is replaced: a device, a pipe, a socket or a symbolic link is refused. Without
/// `mode`, a file that is replaced keeps its own.
Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes,
                                   std::optional<mode_t> mode = std::nullopt);

/// The name of the file that a temporary one, which an interrupted write left, was to become; empty
/// for other names.
std::string_view target_of_temporary(std::string_view name);

}  // namespace infuse::recording
