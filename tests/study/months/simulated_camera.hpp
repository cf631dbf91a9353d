#pragma once

#include <optional>
#include <random>
#include <string>

#include "daemon/calibration/calibration_command.hpp"
#include "daemon/config/calibration_settings.hpp"
#include "daemon/protocol/reports.hpp"
#include "tests/study/months/fault.hpp"

namespace infuse::study {

/// A camera that may be moved, and its calibration's guard: the sequential test and the supervisor
/// are the product's; evaluations of images are drawn around the true offset, re-estimates around
/// the true pose.
///
/// Faults: turned RAD (about y, for good), slid M (along x, for good), black, frozen, dirty, late S
/// (stamps), unclear (re-estimates without a result), misled RAD (re-estimates wrong by that).
class SimulatedCamera {
 public:
  SimulatedCamera(std::string name, const Eigen::Isometry3d& T_true, uint64_t seed)
      : name_(std::move(name)), T_true_(T_true), random_(seed) {}

  /// Begins a run of the daemon, with the calibration that it uses then.
  void restart(const Eigen::Isometry3d& T_camera_lidar,
               const daemon::CalibrationSettings& settings);

  /// Monitors during a second. Returns a report if one is due. `observed`: images and sweeps came.
  std::optional<daemon::CalibrationReport> observe(Stamp now, bool observed,
                                                   const FaultSchedule& faults);

  /// A command of the owner.
  void handle(const daemon::CalibrationCommand& command, Stamp now);

  const Eigen::Isometry3d& T_true() const { return T_true_; }
  const Eigen::Isometry3d& T_used() const { return supervisor_->current(); }
  monitoring::CalibrationState state() const { return supervisor_->state(); }

 private:
  void move(const FaultSchedule& faults);
  monitoring::AxisEvaluation evaluate(double late);
  monitoring::MonitorReport report_of(Stamp now, const FaultSchedule& faults);
  monitoring::Reestimate reestimate(const FaultSchedule& faults);
  daemon::CalibrationReport daemon_report(const monitoring::MonitorReport& monitor);
  void restart_evidence(Stamp now);
  double noise(double sigma) { return std::normal_distribution<double>(0, sigma)(random_); }

  std::string name_;
  Eigen::Isometry3d T_true_;
  std::mt19937_64 random_;
  daemon::CalibrationSettings settings_;
  std::optional<monitoring::DriftDetector> detector_;
  std::optional<monitoring::CalibrationSupervisor> supervisor_;
  Stamp last_without_evidence_ = Stamp::earliest();
  std::optional<Stamp> reported_at_;
  std::optional<monitoring::Reestimate> last_result_;
  Stamp since_;
  uint64_t evaluations_ = 0;
  uint64_t decision_ = 0;
  bool commanded_ = false;  // since the last observation
};

}  // namespace infuse::study
