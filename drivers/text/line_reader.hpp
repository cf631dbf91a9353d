#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::text {

/// Reads a text file line by line in fixed memory. Allocates nothing after `open`.
class LineReader {
 public:
  static constexpr size_t kMaxLineBytes = 65536;  ///< longer lines are skipped

  /// Opens a regular file.
  static Result<LineReader> open(const std::filesystem::path& path);

  /// Reads the next line without its end (LF or CRLF), valid until the next call. Returns false at
  /// the end of the file.
  bool next(std::string_view& line);

  /// Number of the last line read, from 1.
  uint64_t line_number() const { return line_number_; }

  /// Number of lines longer than `kMaxLineBytes`.
  uint64_t too_long_lines() const { return too_long_lines_; }

 private:
  explicit LineReader(File file) : file_(std::move(file)), buffer_(2 * kMaxLineBytes) {}
  bool refill();

  File file_;
  std::vector<char> buffer_;
  size_t begin_ = 0, end_ = 0;  // unread part of the buffer
  uint64_t line_number_ = 0;
  uint64_t too_long_lines_ = 0;
};

}  // namespace infuse::text
