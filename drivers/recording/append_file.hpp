#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// A text file that is appended to during a recording. On disk it always ends after a whole line:
/// if a write fails, for example because the disk is full, the file is truncated to the last one.
class AppendFile {
 public:
  /// Creates the file with mode 0640. Fails if it already exists.
  static Result<AppendFile> create(const std::filesystem::path& path);

  AppendFile(AppendFile&& other) noexcept = default;
  AppendFile& operator=(AppendFile&& other) noexcept;
  /// Writes the buffered lines; errors are ignored.
  ~AppendFile();

  /// Appends a line, with its end, to the buffer.
  void add(std::string_view line) { buffer_ += line; }

  /// Writes the buffered lines to the file. If that fails, none of them is in the file.
  Result<void> flush();

  /// Number of bytes in the file and the buffer.
  uint64_t bytes() const { return written_ + buffer_.size(); }

 private:
  AppendFile(std::filesystem::path path, host::FileDescriptor file)
      : path_(std::move(path)), file_(std::move(file)) {}

  std::filesystem::path path_;
  host::FileDescriptor file_;
  std::string buffer_;
  uint64_t written_ = 0;
};

}  // namespace infuse::recording
