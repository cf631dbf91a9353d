#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// The file's name in the daemon's state folder.
inline constexpr const char* kCalibrationsFile = "calibrations.json";

/// The calibration in use of one camera, and the one that was configured when it was found.
struct SavedCalibration {
  std::string camera;
  Stamp since;          ///< of its use
  bool frozen = false;  ///< the owner wants nothing changed
  Eigen::Isometry3d T_camera_lidar_configured = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
};

/// The text of some, and back. What is of another form, or no rigid motion, is an error.
std::string format_calibrations(const std::vector<SavedCalibration>& calibrations);
Result<std::vector<SavedCalibration>> parse_calibrations(std::string_view text);

/// Keeps the calibrations in use over a restart, in a file that a power cut leaves whole.
class SavedCalibrations {
 public:
  /// `path` empty: nothing is kept.
  explicit SavedCalibrations(std::filesystem::path path) : path_(std::move(path)) {}

  /// Reads the file and puts what was in use into the rig, camera by camera; where the owner has
  /// configured another calibration since, that one counts. What is to be told of it, a line each.
  std::vector<std::string> restore(Rig& rig);

  /// The cameras whose calibrations the owner had frozen.
  std::vector<std::string> frozen_cameras() const;

  /// Writes the file where a calibration in use has changed, or was frozen or let go.
  Result<void> save(const CalibrationReport& report);

 private:
  std::filesystem::path path_;
  std::vector<SavedCalibration> calibrations_;  // a camera each
};

}  // namespace infuse::daemon
