#include "daemon/tools/fleet/fleet_summary.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "fusion/calibration/distributions.hpp"
#include "fusion/monitoring/drift_verdict.hpp"

namespace infuse::daemon {
namespace {

using calibration::ChangeKind;
using calibration::PoseChange;
using calibration::PoseVerdict;
using geometry::Matrix6;

/// How serious a verdict is.
int rank_of(PoseVerdict verdict) {
  switch (verdict) {
    case PoseVerdict::kOnePose:
      return 0;
    case PoseVerdict::kSingle:
      return 1;
    case PoseVerdict::kNone:
      return 2;
    case PoseVerdict::kInconsistent:
      return 3;
    case PoseVerdict::kDrift:
      return 4;
  }
  return 4;
}

CameraSummary& camera_of(VehicleSummary& vehicle, const EntryCalibration& calibration) {
  for (CameraSummary& camera : vehicle.cameras) {
    if (camera.camera == calibration.camera && camera.lidar == calibration.lidar) return camera;
  }
  vehicle.cameras.push_back({.camera = calibration.camera, .lidar = calibration.lidar});
  return vehicle.cameras.back();
}

void add_entry(const DriveEntry& entry, VehicleSummary& vehicle) {
  ++vehicle.drives;
  if (!entry.failures.empty()) ++vehicle.failed;
  vehicle.driven_s += std::max(entry.driven_s.value_or(0), 0.0);
  vehicle.alerts += std::clamp<int64_t>(entry.alerts.value_or(0), 0, 1'000'000'000);
  for (const EntryCalibration& calibration : entry.calibrations) {
    CameraSummary& camera = camera_of(vehicle, calibration);
    (calibration.usable() ? camera.drives : camera.unusable)
        .push_back({entry.drive, entry.stamp.value_or(Stamp()), calibration});
  }
}

/// The pose of a camera in a rig.
std::optional<Eigen::Isometry3d> rig_pose(const std::map<std::string, Rig>& rigs,
                                          const std::string& vehicle, const std::string& camera) {
  const auto rig = rigs.find(vehicle);
  if (rig == rigs.end()) return std::nullopt;
  const CameraMount* mount = rig->second.find_camera(camera);
  if (mount == nullptr) return std::nullopt;
  return mount->T_camera_lidar;
}

RigDifference difference_from_rig(const CameraSummary& camera, double significance) {
  RigDifference difference;
  difference.offset =
      geometry::log(camera.history.current.T_camera_lidar * camera.T_rig->inverse());
  difference.p_value = calibration::chi_squared_exceeded(
      difference.offset.dot(camera.covariance.llt().solve(difference.offset)), 6);
  difference.differs = difference.p_value < significance;
  return difference;
}

void pool_camera(CameraSummary& camera, const calibration::PoseDriftOptions& options) {
  const auto by_date = [](const CameraDrive& a, const CameraDrive& b) {
    return std::pair(a.stamp, a.drive) < std::pair(b.stamp, b.drive);
  };
  std::sort(camera.drives.begin(), camera.drives.end(), by_date);
  std::sort(camera.unusable.begin(), camera.unusable.end(), by_date);
  if (camera.drives.size() > kMaxPooledDrives) {
    camera.left_out = camera.drives.size() - kMaxPooledDrives;
    camera.drives.erase(camera.drives.begin(),
                        camera.drives.begin() + static_cast<ptrdiff_t>(camera.left_out));
  }
  std::vector<calibration::DatedCalibration> calibrations;
  Matrix6 shared = Matrix6::Zero();
  for (const CameraDrive& drive : camera.drives) {
    const double days =
        static_cast<double>(drive.stamp.ns() - camera.drives.front().stamp.ns()) / 86'400e9;
    calibrations.push_back({days, drive.calibration.T_camera_lidar, drive.calibration.covariance});
    shared += drive.calibration.shared_covariance / static_cast<double>(camera.drives.size());
  }
  const Eigen::Isometry3d T_reference = camera.T_rig ? *camera.T_rig
                                        : camera.drives.empty()
                                            ? Eigen::Isometry3d::Identity()
                                            : camera.drives.front().calibration.T_camera_lidar;
  camera.history = calibration::find_pose_drift(calibrations, T_reference, options);
  if (!camera.history.usable()) return;
  camera.covariance = camera.history.current.covariance + shared;
  if (camera.T_rig) camera.rig = difference_from_rig(camera, options.significance);
}

/// "rotation about y by +0.40 ± 0.03°".
std::string axis_text(int axis, double offset, double sigma) {
  return monitoring::describe_offset(static_cast<monitoring::Axis>(axis), offset, sigma);
}

std::string change_text(const CameraSummary& camera, const PoseChange& change) {
  const std::string axis =
      axis_text(change.axis, change.change(change.axis), change.sigma(change.axis));
  const std::string begin = date_of(camera.drives[change.first].stamp);
  if (change.kind == ChangeKind::kStep) return fmt::format("drift from {} on: {}", begin, axis);
  return fmt::format("drift from {} on, steadily until {}: {}", begin,
                     date_of(camera.drives[change.last].stamp), axis);
}

}  // namespace

PoseVerdict VehicleSummary::verdict() const {
  PoseVerdict worst = cameras.empty() ? PoseVerdict::kNone : cameras.front().history.verdict;
  for (const CameraSummary& camera : cameras) {
    if (rank_of(camera.history.verdict) > rank_of(worst)) worst = camera.history.verdict;
  }
  return worst;
}

bool VehicleSummary::differs_from_rig() const {
  return std::any_of(cameras.begin(), cameras.end(),
                     [](const CameraSummary& camera) { return camera.rig && camera.rig->differs; });
}

FleetSummary summarise_fleet(std::vector<DriveEntry> entries,
                             const std::map<std::string, Rig>& rigs,
                             const calibration::PoseDriftOptions& options) {
  std::sort(entries.begin(), entries.end(), [](const DriveEntry& a, const DriveEntry& b) {
    return std::tie(a.vehicle, a.drive) < std::tie(b.vehicle, b.drive);
  });
  FleetSummary fleet{.drives = entries.size()};
  for (const DriveEntry& entry : entries) {
    if (fleet.vehicles.empty() || fleet.vehicles.back().name != entry.vehicle) {
      fleet.vehicles.push_back({.name = entry.vehicle});
    }
    add_entry(entry, fleet.vehicles.back());
    for (const StepFailure& failure : entry.failures) {
      fleet.failed.push_back({entry.vehicle, entry.drive, failure});
    }
  }
  for (VehicleSummary& vehicle : fleet.vehicles) {
    std::sort(vehicle.cameras.begin(), vehicle.cameras.end(), [](const auto& a, const auto& b) {
      return std::tie(a.camera, a.lidar) < std::tie(b.camera, b.lidar);
    });
    for (CameraSummary& camera : vehicle.cameras) {
      camera.T_rig = rig_pose(rigs, vehicle.name, camera.camera);
      pool_camera(camera, options);
    }
  }
  return fleet;
}

const char* name_of(PoseVerdict verdict) {
  switch (verdict) {
    case PoseVerdict::kNone:
      return "no_calibration";
    case PoseVerdict::kSingle:
      return "single_drive";
    case PoseVerdict::kOnePose:
      return "one_pose";
    case PoseVerdict::kDrift:
      return "drift";
    case PoseVerdict::kInconsistent:
      return "inconsistent";
  }
  return "";
}

std::string describe(const CameraSummary& camera) {
  const calibration::PoseHistory& history = camera.history;
  std::string text;
  switch (history.verdict) {
    case PoseVerdict::kNone:
      return "no usable calibration";
    case PoseVerdict::kSingle:
      text = "one calibration, nothing to compare it with";
      break;
    case PoseVerdict::kOnePose:
      text =
          fmt::format("one pose (chi-square {:.1f} of {} degrees of freedom, p {:.2g})",
                      history.all.chi_squared, history.all.degrees_of_freedom, history.all.p_value);
      break;
    case PoseVerdict::kInconsistent:
      text = history.usable()
                 ? fmt::format(
                       "differences {:.1f} times as large as stated, and no date at which "
                       "they begin",
                       std::sqrt(history.scale))
                 : history.reason;
      break;
    case PoseVerdict::kDrift:
      for (const PoseChange& change : history.changes) {
        text += (text.empty() ? "" : "; ") + change_text(camera, change);
      }
      break;
  }
  if (camera.rig && camera.rig->differs) {
    int axis = 0;
    const geometry::Vector6 sigma = camera.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    camera.rig->offset.cwiseAbs().cwiseQuotient(sigma).maxCoeff(&axis);
    text += "; off the rig's pose: " + axis_text(axis, camera.rig->offset(axis), sigma(axis));
  }
  return text;
}

std::string date_of(Stamp stamp) {
  // Years of four digits: what a stamp of int64 can be, 1677 … 2262.
  return fmt::format("{:%Y-%m-%d}",
                     fmt::gmtime(static_cast<std::time_t>(stamp.ns() / 1'000'000'000)));
}

}  // namespace infuse::daemon
