#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// Name of the file in the daemon's state folder.
inline constexpr const char* kCalibrationsFile = "calibrations.json";
/// Version of its format. "frozen" was added without a new one: it may be absent.
inline constexpr int kCalibrationsForm = 1;

/// Calibration in use of one camera, and the configured one when it was saved.
struct SavedCalibration {
  std::string camera;
  Stamp since;          ///< begin of its use
  bool frozen = false;  ///< no automatic changes
  Eigen::Isometry3d T_camera_lidar_configured = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
};

/// Returns the text of the file.
std::string format_calibrations(const std::vector<SavedCalibration>& calibrations);
/// Parses the text of the file. Errors: another format, or a matrix that is not a rigid motion.
Result<std::vector<SavedCalibration>> parse_calibrations(std::string_view text);

/// Keeps the calibrations in use across restarts, in a file that survives a power cut.
class SavedCalibrations {
 public:
  /// `path` empty: nothing is saved.
  explicit SavedCalibrations(std::filesystem::path path) : path_(std::move(path)) {}

  /// Reads the file and sets the saved calibrations in the rig, camera by camera. A configured
  /// calibration that has changed since takes precedence. A file that cannot be read, damaged or of
  /// another release, is kept beside it with the suffix .unreadable. Returns lines for the log.
  std::vector<std::string> restore(Rig& rig);

  /// Why the file could not be read; nothing if it could.
  const std::optional<std::string>& damage() const { return damage_; }

  /// Returns the cameras with a frozen calibration.
  std::vector<std::string> frozen_cameras() const;

  /// Writes the file if the calibration in use has changed, or if an earlier change could not be
  /// written.
  Result<void> save(const CalibrationReport& report);

  /// Writes the file if the calibration of `camera` (empty: of all) is frozen from now on, or no
  /// longer.
  Result<void> save_frozen(const std::string& camera, bool frozen);

 private:
  Result<void> write();

  std::filesystem::path path_;
  std::vector<SavedCalibration> calibrations_;  // one per camera
  bool unsaved_ = false;                        // a change is not in the file
  std::optional<std::string> damage_;
};

}  // namespace infuse::daemon
