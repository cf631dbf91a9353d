#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/protocol/json.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {

/// Calibration of one camera on one drive.
struct EntryCalibration {
  std::string camera, lidar;
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  /// Of what differs between drives (scenes, motion), and of what they share (intrinsics, clocks).
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
  geometry::Matrix6 shared_covariance = geometry::Matrix6::Zero();
  std::string reason;  ///< why it is not used; empty if it is

  bool usable() const { return reason.empty(); }
};

/// A step that failed on a drive: its name ("calibrate") and why.
struct StepFailure {
  std::string step, what;
};

/// What one drive gave.
struct DriveEntry {
  std::string vehicle, drive;
  std::optional<Stamp> stamp;  ///< when it was driven
  std::vector<EntryCalibration> calibrations;
  std::vector<StepFailure> failures;
  std::optional<double> driven_s;  ///< of a replay
  std::optional<int64_t> alerts;   ///< of a replay
};

/// Names of a drive and, optionally, its date ("2026-03-01"), which stands for its stamps.
struct DriveName {
  std::string vehicle, drive, date;

  /// What is wrong with the names, or nothing.
  std::optional<std::string> invalid() const;
};

/// Makes the entry of a drive, a JSON object, from a folder with files of each step: NAME.code
/// (exit code), NAME.json (standard output) and NAME.log (standard error). A step that failed gives
/// its reason. Without durations, so that the bytes do not depend on the machine. Errors: a folder
/// that cannot be read or has no step.
Result<Json> make_drive_entry(const std::filesystem::path& steps, const DriveName& name);

/// Parses an entry. Errors: other text; a calibration that is damaged has that as its reason.
Result<DriveEntry> parse_drive_entry(std::string_view text, const std::string& file);

/// Reads an entry from disk.
Result<DriveEntry> read_drive_entry(const std::filesystem::path& path);

}  // namespace infuse::daemon
