#pragma once

#include <filesystem>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/text/csv_reader.hpp"

namespace infuse::recording {

/// Reads a speed.csv: columns stamp_ns, speed (m/s forward at the centre of the rear axle, as an
/// inertial navigation system or a ground radar measures it), and optionally yaw_rate (rad/s,
/// counter-clockwise); a row with a yaw rate may have no speed.
class SpeedCsv {
 public:
  /// Opens a file. Fails if it cannot be opened or lacks a column.
  static Result<SpeedCsv> open(const std::filesystem::path& path);

  /// Reads the next sample, of which only `speed` and perhaps `yaw_rate` are measured. Returns
  /// false at the end. Rows that are not all numbers are skipped.
  bool next(WheelOdometry& sample);

  /// Appends notes about skipped rows.
  void append_notes(std::vector<Error>& notes) const { csv_.append_notes(notes); }

 private:
  explicit SpeedCsv(text::CsvReader csv) : csv_(std::move(csv)) {}
  text::CsvReader csv_;
};

/// Writes a speed.csv of the samples' speeds, and of their yaw rates if `with_yaw_rate`; what is
/// not finite is left empty.
Result<void> write_speed_csv(const std::filesystem::path& path,
                             const std::vector<WheelOdometry>& samples, bool with_yaw_rate = false);

}  // namespace infuse::recording
