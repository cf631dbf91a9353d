#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/reestimate.hpp"

namespace infuse::monitoring {

/// State of a calibration.
enum class CalibrationState : uint8_t {
  kOk,
  kMonitoring,     ///< too few evaluations so far
  kSuspected,      ///< evidence for a drift, below the confirmation threshold
  kConfirmed,      ///< drift; a re-estimation waits for scenes, or its result for the owner
  kRecalibrating,  ///< a re-estimation runs
  kRecalibrated,   ///< a new calibration is in use and on probation
  kUnusable,       ///< the camera has a fault, or re-estimations keep failing: do not use it
};

/// "OK", "MONITORING" …
const char* name_of(CalibrationState state);

/// Use of a re-estimated calibration.
enum class UpdatePolicy : uint8_t {
  kAlertOnly,    ///< proposed; the owner applies it
  kApply,        ///< applied
  kApplyWithin,  ///< applied if it moved by less than the limits, otherwise proposed
};

/// Settings of the supervisor.
struct SupervisorOptions {
  UpdatePolicy policy = UpdatePolicy::kAlertOnly;
  double limit_rotation = 0.05;    ///< rad, of kApplyWithin
  double limit_translation = 0.1;  ///< m, of kApplyWithin
  size_t min_scenes = 30;          ///< scenes since the drift began that a re-estimation needs
  size_t min_scenes_after_timeout = 15;  ///< the same after `scene_timeout`
  double scene_timeout = 40;             ///< s since the confirmation
  double result_delay =
      10;  ///< s of drive time from the start of a re-estimation to the use of its result
  double min_moved = 3.5;  ///< Mahalanobis distance (6 degrees of freedom) below which the
                           ///< present calibration is kept
  int probation_evaluations =
      15;                ///< evaluations over which a new calibration is compared with the old one
  int max_failures = 3;  ///< consecutive re-estimations without a usable result, then unusable
  double retry_interval = 20;  ///< s between re-estimations
  size_t max_history = 64;     ///< maximum number of entries

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Event in the history of a calibration.
struct HistoryEntry {
  Stamp stamp;
  CalibrationState state = CalibrationState::kOk;                    ///< after it
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< in use after it
  std::string what;  ///< "drift confirmed: rotation about y, by +0.52 ± 0.03 °", "applied", "rolled
                     ///< back: …"
};

/// Actions that the caller has to perform.
struct SupervisorActions {
  CalibrationState state = CalibrationState::kMonitoring;
  bool state_changed = false;       ///< the state differs from the one before
  bool start_reestimation = false;  ///< start a re-estimation from the scenes since `scenes_since`
  Stamp scenes_since;               ///< for `start_reestimation`
  bool cancel_reestimation =
      false;  ///< stop the running re-estimation; do not call `finish_reestimation` for it
  bool calibration_changed =
      false;  ///< `current()` changed: pass it on to the monitor and publish it
  bool alternative_changed = false;  ///< `alternative()` changed: pass it on to the monitor
};

/// State machine of one camera's calibration, in drive time, deterministic. Consumes reports and
/// results of re-estimations and returns the actions to perform; has no side effects.
///
/// OK ⇄ SUSPECTED ⇄ CONFIRMED by the monitor's evidence; CONFIRMED → RECALIBRATING once enough
/// scenes are stored since the earliest begin of the drift; a usable result is proposed or applied
/// (policy). On probation after that, the old calibration is the alternative that every evaluation
/// is compared with: if the dependence on following scenes is not higher than with the old one, the
/// new one is rolled back. With a camera fault the state is UNUSABLE and nothing is re-estimated.
class CalibrationSupervisor {
 public:
  /// `options.invalid()` must be empty.
  CalibrationSupervisor(const Eigen::Isometry3d& T_camera_lidar, const SupervisorOptions& options);

  /// Processes the report of an image. `scenes`: number of stored scenes since `report.since`.
  SupervisorActions process(const MonitorReport& report, size_t scenes);

  /// Hands over the result of the re-estimation that was started; the first `process` at least
  /// `result_delay` after the start uses it.
  void finish_reestimation(const Reestimate& result);

  /// Requests a re-estimation. Requests of the owner take effect with the next `process`.
  void request_recalibration() { recalibration_requested_ = true; }
  /// Requests that the proposal is applied, if there is one.
  void request_apply() { apply_requested_ = true; }
  /// Requests the previous calibration.
  void request_roll_back() { roll_back_requested_ = true; }
  /// Freezes the calibration: nothing is applied or re-estimated, and a running re-estimation is
  /// cancelled; monitoring goes on. The owner can still request a re-estimation, which is then
  /// proposed.
  void set_frozen(bool frozen) { frozen_requested_ = frozen; }

  CalibrationState state() const { return state_; }
  const Eigen::Isometry3d& current() const { return current_; }
  const std::optional<Eigen::Isometry3d>& alternative() const { return alternative_; }
  /// True if there is a calibration before the current one.
  bool can_roll_back() const { return previous_.has_value(); }
  /// Usable result that is not applied.
  const std::optional<Reestimate>& proposal() const { return proposal_; }
  /// Covariance of the current calibration, if it was re-estimated.
  const std::optional<geometry::Matrix6>& covariance() const { return covariance_; }
  bool frozen() const { return frozen_; }
  /// True if a re-estimation was started and its result is not used yet.
  bool reestimating() const { return reestimating_; }
  /// Events, oldest first.
  const std::vector<HistoryEntry>& history() const { return history_; }

 private:
  void apply_requests(const MonitorReport& report, SupervisorActions& actions);
  void update_state(const MonitorReport& report, SupervisorActions& actions);
  void start_reestimation_if_due(const MonitorReport& report, size_t scenes,
                                 SupervisorActions& actions);
  void use_result_if_due(const MonitorReport& report, SupervisorActions& actions);
  void check_probation(const MonitorReport& report, SupervisorActions& actions);
  void set_current(const Eigen::Isometry3d& T, Stamp stamp, const std::string& what,
                   SupervisorActions& actions);
  void cancel_reestimation(SupervisorActions& actions);
  void revert_to_previous(Stamp stamp, const std::string& cause, SupervisorActions& actions);
  bool policy_allows(const Reestimate& result) const;
  void add_history(Stamp stamp, std::string what);

  SupervisorOptions options_;
  CalibrationState state_ = CalibrationState::kMonitoring;
  Eigen::Isometry3d current_;
  std::optional<Eigen::Isometry3d> alternative_;  // previous calibration, on probation
  std::optional<Eigen::Isometry3d> previous_;     // previous calibration, for the owner
  std::optional<geometry::Matrix6> covariance_;
  std::optional<Reestimate> proposal_;
  std::optional<Reestimate> result_;  // not used yet
  bool reestimating_ = false;
  Stamp reestimation_started_;
  Stamp next_retry_ = Stamp::earliest();
  Stamp confirmed_since_;  // stamp of the confirmation
  int failures_ = 0;
  double gain_sum_ = 0;
  int gain_count_ = 0;
  bool recalibration_requested_ = false, apply_requested_ = false, roll_back_requested_ = false;
  std::optional<bool> frozen_requested_;
  bool frozen_ = false;
  std::vector<HistoryEntry> history_;
};

}  // namespace infuse::monitoring
