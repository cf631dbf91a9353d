#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// Reads a text file line by line in fixed memory; nothing is allocated after `open`.
class LineReader {
 public:
  static constexpr size_t kMaxLineBytes = 65536;  ///< bytes; longer lines are passed over

  static Result<LineReader> open(const std::filesystem::path& path);

  /// The next line without its end (LF or CRLF), valid until the next call; false at the end.
  bool next(std::string_view& line);

  /// Number of the line that `next` gave last, from 1.
  uint64_t line_number() const { return line_number_; }

  /// Lines that were longer than `kMaxLine`.
  uint64_t too_long_lines() const { return too_long_lines_; }

 private:
  struct Close {
    void operator()(FILE* file) const { std::fclose(file); }
  };
  explicit LineReader(FILE* file) : file_(file), buffer_(2 * kMaxLineBytes) {}
  bool refill();

  std::unique_ptr<FILE, Close> file_;
  std::vector<char> buffer_;
  size_t begin_ = 0, end_ = 0;  // what of the buffer is not handed out yet
  uint64_t line_number_ = 0;
  uint64_t too_long_lines_ = 0;
};

}  // namespace infuse::recording
