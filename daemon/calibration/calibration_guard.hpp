#pragma once

#include <vector>

#include "daemon/calibration/background_worker.hpp"
#include "daemon/config/calibration_settings.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/protocol/request.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// Keeps the calibration of one camera true: watches it on the fusion thread, has it estimated anew
/// in the background, and does what is decided. In drive time: where `waits`, the same drive gives
/// the same at any rate.
class CalibrationGuard {
 public:
  /// How often the calibration is told without a change.
  static constexpr Duration kReportInterval{10'000'000'000};

  /// `settings.invalid()` must be empty.
  CalibrationGuard(const CameraMount& mount, const CalibrationSettings& settings, bool blocking);

  /// Takes a picture (kGrey8) and the returns of its sweep as of its exposure. True where
  /// `report()` is to be told.
  bool process(const CameraFrame& grey, const monitoring::SweepView& sweep,
               const monitoring::Motion& motion);

  /// What the owner asks for; comes into effect with the next picture.
  void handle_request(const Request& request);

  /// No re-estimation goes on or begins from now on; from any thread.
  void shut_down() { background_.shut_down(); }

  /// The calibration in use.
  const Eigen::Isometry3d& T_camera_lidar() const { return supervisor_.current(); }

  /// How it stood after the last picture.
  const CalibrationReport& report() const { return report_; }

 private:
  void start_reestimation(const monitoring::SupervisorActions& actions, Stamp now);
  void fill_report(const monitoring::MonitorReport& monitor_report);

  CameraIntrinsics intrinsics_;
  CalibrationSettings settings_;
  monitoring::CalibrationMonitor monitor_;
  monitoring::CalibrationSupervisor supervisor_;
  std::vector<monitoring::StoredScene> scenes_;        // of the background's work
  monitoring::Reestimate result_;                      // the same
  std::optional<monitoring::Reestimate> last_result_;  // the last result
  uint64_t evaluations_ = 0;
  std::optional<Stamp> reported_at_;
  CalibrationReport report_;
  BackgroundWorker background_;  // the last: its work uses the others
};

}  // namespace infuse::daemon
