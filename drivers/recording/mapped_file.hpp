#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// A file in memory, read when it is touched. It must not be cut while it is mapped; files that are
/// replaced whole (`write_file_atomically`) may be.
class MappedFile {
 public:
  /// Nothing mapped.
  MappedFile() = default;
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }

  /// Maps a file for reading; fails where it is not there, is no regular file, or is empty.
  static Result<MappedFile> open(const std::filesystem::path& path);

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

/// Writes a file beside `path`, flushes it to the disk and renames it into place: whoever reads
/// `path` finds the old file or the new one, whole.
Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes);

}  // namespace infuse::recording
