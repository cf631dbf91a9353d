#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/text/line_reader.hpp"

namespace infuse::text {

/// A column of a CSV file, identified by its name in the header line.
struct CsvColumn {
  std::string_view name;
  bool required = true;
};

/// Reads comma-separated values (without quoting) that follow a header line, in fixed memory.
class CsvReader {
 public:
  /// Opens a file. Fails if it cannot be opened or its header lacks a required column. `columns`
  /// must outlive the reader.
  static Result<CsvReader> open(const std::filesystem::path& path,
                                std::span<const CsvColumn> columns);

  /// Reads the next row: its fields in the order of `columns`, empty where the row has none, valid
  /// until the next call. Returns false at the end. Empty lines and lines that begin with # are
  /// skipped.
  bool next(std::span<std::string_view> fields);

  /// Records that the last row is invalid, and why.
  void reject(const std::string& why);

  /// Appends one note about the rows rejected so far and one about overlong lines, if any.
  void append_notes(std::vector<Error>& notes) const;

  /// Location of the last row as "FILE:LINE".
  std::string where() const;

 private:
  CsvReader(LineReader lines, std::string file)
      : lines_(std::move(lines)), file_(std::move(file)) {}

  LineReader lines_;
  std::string file_;
  std::vector<size_t> positions_;  // index of each column in a row; npos if absent
  uint64_t rejected_rows_ = 0;
  Error first_rejection_;
};

}  // namespace infuse::text
