#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::text {
/// Closes a file that a `File` owns.
struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;  ///< an open file

/// Opens a regular file to read. Folders, pipes and devices, which may never end, are errors.
Result<File> open_regular_file(const std::filesystem::path& path);

/// Reads a whole regular file of at most `max_bytes`. Larger files are errors.
Result<std::string> read_text(const std::filesystem::path& path, size_t max_bytes);

/// The rest of an open file of at most `max_bytes`; `path` is said in errors.
Result<std::string> read_text(std::FILE* file, const std::filesystem::path& path, size_t max_bytes);

/// Creates or overwrites a file. Fails if not all of it could be written.
Result<void> write_text(const std::filesystem::path& path, std::string_view text);

}  // namespace infuse::text
