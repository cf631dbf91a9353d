#pragma once

#include <map>
#include <string>
#include <vector>

#include "daemon/tools/fleet/drive_entry.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/calibration/pose_drift.hpp"

namespace infuse::daemon {

/// One drive's calibration of a camera.
struct CameraDrive {
  std::string drive;
  Stamp stamp;
  EntryCalibration calibration;
};

/// How the pooled pose lies to the one that the rig states.
struct RigDifference {
  geometry::Vector6 offset = geometry::Vector6::Zero();  ///< left perturbation of the rig's pose
  double p_value = 1;  ///< of so large an offset if the rig is right
  bool differs = false;
};

/// One camera of a vehicle over its drives.
struct CameraSummary {
  std::string camera, lidar;
  /// Usable calibrations by date; the latest `kMaxPooledDrives`.
  std::vector<CameraDrive> drives;
  std::vector<CameraDrive> unusable;
  size_t left_out = 0;  ///< older ones beyond the maximum
  calibration::PoseHistory history;
  /// Of the pooled pose, with what the drives share.
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
  std::optional<Eigen::Isometry3d> T_rig;  ///< T_camera_lidar of the rig, if it is given
  std::optional<RigDifference> rig;        ///< if there is a pooled pose too
};

/// A drive on which a step failed.
struct FailedDrive {
  std::string vehicle, drive;
  StepFailure failure;
};

/// One vehicle.
struct VehicleSummary {
  std::string name;
  size_t drives = 0, failed = 0;       ///< failed: those with a step that failed
  double driven_s = 0;                 ///< of replays
  int64_t alerts = 0;                  ///< of replays
  std::vector<CameraSummary> cameras;  ///< by name

  /// The most serious verdict of its cameras.
  calibration::PoseVerdict verdict() const;
  /// True if the pose of a camera is not the one that the rig states.
  bool differs_from_rig() const;
};

/// The fleet.
struct FleetSummary {
  std::vector<VehicleSummary> vehicles;  ///< by name
  std::vector<FailedDrive> failed;       ///< by vehicle and drive
  size_t drives = 0;
};

/// Maximum number of calibrations of one camera that are pooled.
inline constexpr size_t kMaxPooledDrives = 1000;

/// Pools the calibrations of every camera of every vehicle. `rigs`: of vehicles, by name; the poses
/// they state are the references. The order of `entries` does not matter.
FleetSummary summarise_fleet(std::vector<DriveEntry> entries,
                             const std::map<std::string, Rig>& rigs,
                             const calibration::PoseDriftOptions& options);

/// "one_pose", "drift", "inconsistent", "single_drive", "no_calibration".
const char* name_of(calibration::PoseVerdict verdict);

/// What is found of a camera, in a sentence: "drift from 2026-03-05 on: rotation about y by +0.40 ±
/// 0.03°".
std::string describe(const CameraSummary& camera);

/// The date of a stamp, UTC: "2026-03-05".
std::string date_of(Stamp stamp);

/// The summary as JSON; bytes depend on the entries alone.
Json to_json(const FleetSummary& fleet);

}  // namespace infuse::daemon
