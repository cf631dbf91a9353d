#pragma once

#include <vector>

#include "daemon/calibration/background_worker.hpp"
#include "daemon/calibration/calibration_command.hpp"
#include "daemon/config/calibration_settings.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// Keeps the calibration of one camera valid: monitors it on the fusion thread, re-estimates it in
/// the background, and carries out the supervisor's decisions. All in drive time: if `blocking`,
/// the same drive gives the same reports at any rate.
class CalibrationGuard {
 public:
  /// Interval of reports without a change.
  static constexpr Duration kReportInterval{10'000'000'000};

  /// `settings.invalid()` must be empty. `blocking`: waits for background work (replay).
  CalibrationGuard(const CameraMount& mount, const CalibrationSettings& settings, bool blocking);

  /// Compares images with the places of the rig's other cameras too; this one is `camera` there.
  /// Outlives the guard.
  void set_assignment(monitoring::CameraAssignment& assignment, size_t camera) {
    monitor_.set_assignment(assignment, camera);
  }

  /// Processes an image (kGrey8) and the returns of its sweep as of its exposure. Returns the
  /// report if one is due, valid until the next call, else null.
  const CalibrationReport* process(const CameraFrame& grey, const monitoring::SweepView& sweep,
                                   const monitoring::Motion& motion);

  /// Carries out a command of the owner at once. Returns the report of it, valid until the next
  /// call.
  const CalibrationReport* handle(const CalibrationCommand& command, Stamp now);

  /// Returns the report if none was made for `kReportInterval`, as without images; else null.
  const CalibrationReport* report_if_due(Stamp now);

  /// Returns the report at the end of a drive; null if nothing has changed since the last.
  const CalibrationReport* report_at_end(Stamp now);

  /// Stops the background work, and starts none from now on; from any thread.
  void shut_down() {
    search_.shut_down();
    background_.shut_down();
  }

  /// The calibration in use.
  const Eigen::Isometry3d& T_camera_lidar() const { return supervisor_.current(); }

  /// T_camera_lidar of the last re-estimation, usable or not; null before the first.
  const Eigen::Isometry3d* estimate() const {
    return last_result_ ? &last_result_->T_camera_lidar : nullptr;
  }

 private:
  void perform(const monitoring::SupervisorActions& actions, Stamp now);
  void search_drift(Stamp now);
  void start_reestimation(const monitoring::SupervisorActions& actions, Stamp now);
  const CalibrationReport* report(Stamp now, bool changed);
  void fill_report(Stamp now);

  CameraIntrinsics intrinsics_;
  CalibrationSettings settings_;
  monitoring::CalibrationMonitor monitor_;
  monitoring::CalibrationSupervisor supervisor_;
  std::vector<const monitoring::StoredScene*> scenes_;  // lent to the background work
  monitoring::Reestimate result_;                       // written by the background work
  std::optional<monitoring::Reestimate> last_result_;
  monitoring::MonitorReport observed_;  // the last
  double dependence_ = 0;               // of the last evaluation
  uint64_t evaluations_ = 0;
  std::optional<Stamp> reported_at_;
  CalibrationReport report_;
  BackgroundWorker search_;      // of the monitor's drift
  BackgroundWorker background_;  // last members: their work uses the others
};

}  // namespace infuse::daemon
