#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

namespace infuse::fuzz {

/// A file for readers that take a path: overwritten by each input, removed at the end.
class FuzzFile {
 public:
  /// `ending` is that of the file's name, with its dot.
  explicit FuzzFile(const std::string& ending)
      : path_(std::filesystem::temp_directory_path() /
              ("infuse-fuzz-" + std::to_string(::getpid()) + ending)) {}
  ~FuzzFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  FuzzFile(const FuzzFile&) = delete;
  FuzzFile& operator=(const FuzzFile&) = delete;

  /// Replaces the content and returns the path.
  const std::filesystem::path& write(std::span<const uint8_t> content) {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()),
               static_cast<std::streamsize>(content.size()));
    return path_;
  }

 private:
  std::filesystem::path path_;
};

}  // namespace infuse::fuzz
