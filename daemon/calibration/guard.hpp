#pragma once

#include <vector>

#include "daemon/calibration/background.hpp"
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
  static constexpr Duration kTellEvery{10'000'000'000};

  /// `settings.invalid()` must be empty.
  CalibrationGuard(const CameraMount& mount, const CalibrationSettings& settings, bool waits);

  /// Takes a picture (kGrey8) and the returns of its sweep as of its exposure. True where
  /// `report()` is to be told.
  bool take(const CameraFrame& grey, const watch::SweepView& sweep, const watch::Motion& motion);

  /// What the owner asks for; comes into effect with the next picture.
  void obey(const Request& request);

  /// No re-estimation goes on or begins from now on; from any thread.
  void shut_down() { background_.shut_down(); }

  /// The calibration in use.
  const Eigen::Isometry3d& T_camera_lidar() const { return decision_.present(); }

  /// How it stood after the last picture.
  const CalibrationReport& report() const { return report_; }

 private:
  void start(const watch::Decided& decided, Stamp now);
  void fill_report(const watch::WatchReport& seen);

  CameraIntrinsics intrinsics_;
  CalibrationSettings settings_;
  watch::Watch watch_;
  watch::Decision decision_;
  std::vector<watch::StoredScene> scenes_;  // of the background's work
  watch::Reestimate result_;                // the same
  std::optional<watch::Reestimate> last_;   // the last result
  uint64_t looks_ = 0;
  std::optional<Stamp> told_;
  CalibrationReport report_;
  Background background_;  // the last: its work uses the others
};

}  // namespace infuse::daemon
