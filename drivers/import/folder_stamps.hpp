#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/import/import_files.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/recording/toml_library.hpp"

namespace infuse::importers {

/// How files get their stamps: by a table of text, by their names, or by a rate.
struct StampRule {
  std::string file;               ///< table, relative to the description; empty: none
  std::string column;             ///< of its stamps: name, or number from 1; empty: the first
  std::string files_column;       ///< of its file names; empty: row k is of the k-th file
  bool names = false;             ///< the stamp is the last number in the file's name
  std::optional<double> rate_hz;  ///< the k-th file is at start + k / rate
  std::optional<Stamp> start;     ///< absent: when the recording's first packet came
  std::string unit = "s";         ///< of stamps: "s" (or a date and time in UTC), "ms", "us", "ns"
  Duration offset = Duration::zero();  ///< added to all

  /// Returns what is wrong, or nothing: not exactly one of the three, an unknown unit.
  std::optional<std::string> invalid() const;
};

/// Reads the keys of a `stamps` table. Errors have file and line.
Result<StampRule> read_stamp_rule(const toml::table& table, const std::string& file);

/// A row of a table of stamps.
struct StampRow {
  Stamp stamp;
  std::string file;  ///< without its folder; empty if the table has no column of files
  size_t line = 0;   ///< from 1
};

/// Parses a table of stamps: fields between commas, semicolons, tabulators or blanks, whichever the
/// first line has; it may be a header. Lines that begin with # are comments. Errors have file and
/// line.
Result<std::vector<StampRow>> parse_stamp_rows(std::string_view text, const std::string& file,
                                               const StampRule& rule);

/// Parses a stamp in a unit of `StampRule`, exactly. Returns nothing if it is malformed or not
/// within 1970 … 2105.
std::optional<Stamp> parse_stamp_in(std::string_view text, const std::string& unit);

/// Returns the stamp in a file's name without extension: "frame_1700000000123" in ms.
std::optional<Stamp> parse_stamp_in_name(std::string_view stem, const std::string& unit);

/// Lists the files of a folder with one of the extensions, in lower case, in the order of the
/// numbers in their names.
Result<std::vector<std::filesystem::path>> list_in_order(
    const std::filesystem::path& folder, const std::vector<std::string>& extensions);

/// Gives files, in order, their stamps; the result is in order of these. `start` stands in for the
/// rule's. Appends what is left out to `notes`. Errors: a name without a stamp, another number of
/// rows than of files.
Result<std::vector<StampedFile>> stamp_files(const std::vector<std::filesystem::path>& files,
                                             const StampRule& rule,
                                             const std::filesystem::path& base, Stamp start,
                                             std::vector<Error>& notes);

}  // namespace infuse::importers
