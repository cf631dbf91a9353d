#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/text/line_reader.hpp"

namespace infuse::recording {

/// A column that is looked for in the header line of a CSV file.
struct CsvColumn {
  std::string_view name;
  bool required = true;
};

/// Reads comma-separated values (no quotes) with a header line, in fixed memory.
class CsvReader {
 public:
  /// Fails where the file cannot be opened or its header lacks a required column. `columns` must
  /// outlive the reader.
  static Result<CsvReader> open(const std::filesystem::path& path,
                                std::span<const CsvColumn> columns);

  /// The fields of the next row, in the order of the columns; empty where the row has none. Valid
  /// until the next call. False at the end. Empty lines and lines that begin with # are passed
  /// over.
  bool next(std::span<std::string_view> fields);

  /// Remembers that the row given last is of no use, and why.
  void reject(const std::string& why);

  /// Says what was rejected so far, in one note; nothing where all was well.
  void append_notes(std::vector<Error>& notes) const;

  /// "FILE:LINE" of the row given last.
  std::string where() const;

 private:
  CsvReader(LineReader lines, std::string file)
      : lines_(std::move(lines)), file_(std::move(file)) {}

  LineReader lines_;
  std::string file_;
  std::vector<size_t> positions_;  // of each column in a row; npos where there is none
  uint64_t rejected_rows_ = 0;
  Error first_rejection_;  // what was rejected first
};

/// The whole field as a number; nothing where it is not one, or not finite.
std::optional<double> parse_number(std::string_view field);
std::optional<int64_t> parse_integer(std::string_view field);

}  // namespace infuse::recording
