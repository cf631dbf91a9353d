#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/text/csv_reader.hpp"

namespace infuse::recording {

/// Reads an imu.csv: columns stamp_ns, wx, wy, wz (rad/s), ax, ay, az (m/s²), vehicle axes, gravity
/// included.
class ImuCsv {
 public:
  static Result<ImuCsv> open(const std::filesystem::path& path);

  /// The next sample, or false at the end. Rows that are not all numbers are left out.
  bool next(ImuSample& sample);

  void append_notes(std::vector<Error>& notes) const { csv_.append_notes(notes); }

 private:
  explicit ImuCsv(CsvReader csv) : csv_(std::move(csv)) {}
  CsvReader csv_;
};

/// Reads a gps.csv: columns stamp_ns, latitude_deg, longitude_deg, and optionally altitude (m),
/// speed (m/s), course_deg (clockwise from north), hdop, utc_ns, valid (0 or 1; absent: 1).
class GnssCsv {
 public:
  static Result<GnssCsv> open(const std::filesystem::path& path);

  /// The next fix, or false at the end. Rows without a stamp or a place are left out.
  bool next(GnssFix& fix);

  void append_notes(std::vector<Error>& notes) const { csv_.append_notes(notes); }

 private:
  explicit GnssCsv(CsvReader csv) : csv_(std::move(csv)) {}
  CsvReader csv_;
};

/// The header line of a gps.csv and a row of it, each with its end.
inline constexpr const char* kGnssCsvHeader =
    "stamp_ns,latitude_deg,longitude_deg,altitude,speed,course_deg,hdop,utc_ns,valid\n";
std::string format_gnss_row(const GnssFix& fix);

/// Write what the readers above read.
Result<void> write_imu_csv(const std::filesystem::path& path,
                           const std::vector<ImuSample>& samples);
Result<void> write_gnss_csv(const std::filesystem::path& path, const std::vector<GnssFix>& fixes);

}  // namespace infuse::recording
