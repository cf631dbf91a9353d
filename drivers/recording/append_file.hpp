#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// A text file that grows while something is recorded. On the disk it only ever ends behind a whole
/// line: where a disk is full it is cut back to that.
class AppendFile {
 public:
  /// Creates the file, readable by the group too; fails where there is one.
  static Result<AppendFile> create(const std::filesystem::path& path);

  AppendFile(AppendFile&& other) noexcept;
  AppendFile& operator=(AppendFile&& other) noexcept;
  /// Writes what waits, without a word where that fails.
  ~AppendFile();

  /// Adds a line, with its end; it waits in memory for `flush`.
  void add(std::string_view line) { buffer_ += line; }

  /// Hands what waits to the system. Where that fails none of it is in the file.
  Result<void> flush();

  /// Bytes in the file and waiting.
  uint64_t bytes() const { return written_ + buffer_.size(); }

 private:
  AppendFile(std::filesystem::path path, int file) : path_(std::move(path)), file_(file) {}

  std::filesystem::path path_;
  int file_ = -1;
  std::string buffer_;
  uint64_t written_ = 0;
};

}  // namespace infuse::recording
