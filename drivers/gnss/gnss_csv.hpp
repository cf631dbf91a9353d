#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/text/csv_reader.hpp"

namespace infuse::gnss {

/// Reads a gnss.csv: columns stamp_ns, latitude_deg, longitude_deg, and optionally altitude (m),
/// speed (m/s), course_deg (clockwise from north), hdop, utc_ns, valid (0 or 1; default 1).
class GnssCsv {
 public:
  /// Opens a file. Fails if it cannot be opened or lacks a required column.
  static Result<GnssCsv> open(const std::filesystem::path& path);

  /// Reads the next fix. Returns false at the end. Rows without a valid stamp, latitude and
  /// longitude are skipped.
  bool next(GnssFix& fix);

  /// Appends notes about skipped rows.
  void append_notes(std::vector<Error>& notes) const { csv_.append_notes(notes); }

 private:
  explicit GnssCsv(text::CsvReader csv) : csv_(std::move(csv)) {}
  text::CsvReader csv_;
};

/// Header line of a gnss.csv, with its line end.
inline constexpr const char* kGnssCsvHeader =
    "stamp_ns,latitude_deg,longitude_deg,altitude,speed,course_deg,hdop,utc_ns,valid\n";

/// Formats a row of a gnss.csv, with its line end.
std::string format_gnss_row(const GnssFix& fix);

/// Writes a gnss.csv.
Result<void> write_gnss_csv(const std::filesystem::path& path, const std::vector<GnssFix>& fixes);

}  // namespace infuse::gnss
