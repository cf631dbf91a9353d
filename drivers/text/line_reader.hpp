#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::text {

/// Reads a text file line by line in fixed memory. Allocates nothing after `open`.
class LineReader {
 public:
  static constexpr size_t kMaxLineBytes = 65536;  ///< longer lines are skipped

  /// Opens a file; fails if it cannot be opened or is a folder.
  static Result<LineReader> open(const std::filesystem::path& path);

  /// Reads the next line without its end (LF or CRLF), valid until the next call. Returns false at
  /// the end of the file.
  bool next(std::string_view& line);

  /// Number of the last line read, from 1.
  uint64_t line_number() const { return line_number_; }

  /// Number of lines longer than `kMaxLineBytes`.
  uint64_t too_long_lines() const { return too_long_lines_; }

 private:
  struct Close {
    void operator()(FILE* file) const { std::fclose(file); }
  };
  explicit LineReader(FILE* file) : file_(file), buffer_(2 * kMaxLineBytes) {}
  bool refill();

  std::unique_ptr<FILE, Close> file_;
  std::vector<char> buffer_;
  size_t begin_ = 0, end_ = 0;  // unread part of the buffer
  uint64_t line_number_ = 0;
  uint64_t too_long_lines_ = 0;
};

}  // namespace infuse::text
