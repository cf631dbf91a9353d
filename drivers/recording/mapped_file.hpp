#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// A file mapped into memory for reading. The file must not be truncated while it is mapped; it may
/// be replaced (`write_file_atomically`).
class MappedFile {
 public:
  /// An empty mapping.
  MappedFile() = default;
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }

  /// Maps a file. Fails if it does not exist, is not a regular file, or is empty.
  static Result<MappedFile> open(const std::filesystem::path& path);

  /// Content of the file.
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace infuse::recording
