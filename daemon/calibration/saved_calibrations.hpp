#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Name of the file in the daemon's state folder.
inline constexpr const char* kCalibrationsFile = "calibrations.json";
/// Version of its format; 1 had the calibration in use alone, without numbers, and is read too.
inline constexpr int kCalibrationsForm = 2;
/// Maximum size of the file: 64 cameras with 32 calibrations, and as much again.
inline constexpr size_t kMaxCalibrationsBytes = size_t{8} << 20;

/// The calibrations of one camera.
struct CameraCalibrations {
  std::string camera;
  bool frozen = false;  ///< no automatic changes
  Eigen::Isometry3d T_camera_lidar_configured = Eigen::Isometry3d::Identity();
  uint64_t in_use = 0;               ///< number
  std::optional<uint64_t> previous;  ///< number of the one in use before
  std::optional<uint64_t> proposed;  ///< number of the one that waits; of this run only
  /// Oldest first. `KnownCalibration::use` follows from the above.
  std::vector<KnownCalibration> known;

  /// Returns the calibration with a number; null if there is none.
  const KnownCalibration* find(uint64_t number) const;
};

/// The file.
struct SavedCalibrations {
  uint64_t next_number = 1;  ///< of all cameras: a number names one calibration of the vehicle
  std::vector<CameraCalibrations> cameras;

  /// Returns the camera; null if it is not known.
  CameraCalibrations* find(const std::string& camera);
};

/// Returns the text of the file.
std::string format_calibrations(const SavedCalibrations& calibrations);
/// Parses the text of the file. Errors: another format, a matrix that is not a rigid motion, a
/// number that is used twice or names nothing.
Result<SavedCalibrations> parse_calibrations(std::string_view text);

}  // namespace infuse::daemon
