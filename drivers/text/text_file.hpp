#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::text {

/// Reads a whole file of at most `max_bytes`. Larger files and folders are errors.
Result<std::string> read_text(const std::filesystem::path& path, size_t max_bytes);

/// Creates or overwrites a file. Fails if not all of it could be written.
Result<void> write_text(const std::filesystem::path& path, std::string_view text);

}  // namespace infuse::text
