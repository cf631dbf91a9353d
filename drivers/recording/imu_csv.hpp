#pragma once

#include <filesystem>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/text/csv_reader.hpp"

namespace infuse::recording {

/// Reads an imu.csv: columns stamp_ns, wx, wy, wz (rad/s), ax, ay, az (m/s²), vehicle axes,
/// including gravity.
class ImuCsv {
 public:
  /// Opens a file. Fails if it cannot be opened or lacks a column.
  static Result<ImuCsv> open(const std::filesystem::path& path);

  /// Reads the next sample. Returns false at the end. Rows that are not all numbers are skipped.
  bool next(ImuSample& sample);

  /// Appends notes about skipped rows.
  void append_notes(std::vector<Error>& notes) const { csv_.append_notes(notes); }

 private:
  explicit ImuCsv(text::CsvReader csv) : csv_(std::move(csv)) {}
  text::CsvReader csv_;
};

/// Writes an imu.csv.
Result<void> write_imu_csv(const std::filesystem::path& path,
                           const std::vector<ImuSample>& samples);

}  // namespace infuse::recording
