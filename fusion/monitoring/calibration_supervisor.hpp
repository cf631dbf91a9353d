#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/calibration_states.hpp"
#include "fusion/monitoring/reestimate.hpp"

namespace infuse::monitoring {

/// Settings of the supervisor.
struct SupervisorOptions {
  UpdatePolicy policy = UpdatePolicy::kAlertOnly;
  double limit_rotation = 0.05;    ///< rad, of kApplyWithin
  double limit_translation = 0.1;  ///< m, of kApplyWithin
  size_t min_scenes = 15;  ///< scenes since the drift began that a re-estimation needs; P 3.4.1.3:
                           ///< 10 to 20. Its covariance decides whether they suffice.
  double result_delay =
      5;  ///< s of drive time from the start of a re-estimation to the use of its result
  double min_moved = 3.5;  ///< Mahalanobis distance (94 % of χ² with 6 degrees) below which the
                           ///< present calibration is kept
  int probation_evaluations =
      15;                ///< evaluations over which a new calibration is compared with the old one
  int max_failures = 3;  ///< consecutive re-estimations without a usable result, then unusable
  double retry_interval = 20;  ///< s between re-estimations
  size_t max_history = 64;     ///< bounds memory: maximum number of entries

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Event in the history of a calibration.
struct HistoryEntry {
  Stamp stamp;
  CalibrationState state = CalibrationState::kOk;                    ///< after it
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< in use after it
  std::string what;  ///< "drift confirmed: rotation about y by +0.52 ± 0.03°", "applied", "rolled
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

  /// True if there is something to publish.
  bool changed() const { return state_changed || calibration_changed || alternative_changed; }
};

/// A calibration that the owner puts into use.
struct OwnerCalibration {
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  std::optional<geometry::Matrix6> covariance;  ///< of an estimate
  bool rolls_back = false;                      ///< it was in use before; without probation
};

/// State machine of one camera's calibration, in drive time, deterministic. Consumes reports,
/// results of re-estimations and requests of the owner, makes events of them (`transition` has the
/// table) and returns the actions to perform; has no side effects.
///
/// A re-estimation is wanted when a drift is confirmed and no proposal waits, or when the owner
/// requests it, and starts once enough scenes are stored since the earliest begin of the drift. A
/// usable result is proposed or applied (policy). A proposal is monitored as the calibration in use
/// is: it is withdrawn when it has drifted too, when the calibration in use turns out to hold, and
/// when another takes its place. On probation, the calibration before is the alternative that every
/// evaluation is compared with: if the dependence on following scenes is not higher than with that
/// one, it is put back into use.
class CalibrationSupervisor {
 public:
  /// `options.invalid()` must be empty.
  CalibrationSupervisor(const Eigen::Isometry3d& T_camera_lidar, const SupervisorOptions& options);

  /// Processes the report of an image. `scenes`: number of stored scenes since `scenes_since`.
  SupervisorActions process(const MonitorReport& report, size_t scenes);

  /// Stamp since which scenes show the present pose of the camera.
  Stamp scenes_since(const MonitorReport& report) const {
    return std::max(report.since, moved_again_);
  }

  /// Hands over the result of the re-estimation that was started; the first `process` at least
  /// `result_delay` after the start uses it. A result for another calibration than the one in use
  /// is ignored.
  void finish_reestimation(const Reestimate& result);

  // Requests of the owner; they take effect at once.

  /// Requests a re-estimation: as soon as there are scenes, no probation runs and the camera has no
  /// fault. After failures they are tried again.
  SupervisorActions request_recalibration(Stamp stamp);
  /// Puts a calibration into use.
  SupervisorActions use(const OwnerCalibration& calibration, Stamp stamp);
  /// Freezes the calibration: nothing is applied, re-estimated or put back, and a running
  /// re-estimation is cancelled; monitoring goes on. The owner can still request a re-estimation,
  /// which is then proposed.
  SupervisorActions freeze(bool frozen, Stamp stamp);

  CalibrationState state() const { return state_; }
  const Eigen::Isometry3d& current() const { return current_; }
  /// Calibration that is monitored beside the current one: the one before, on probation; otherwise
  /// the proposal.
  std::optional<Eigen::Isometry3d> alternative() const;
  /// Usable result that is not applied.
  const std::optional<Reestimate>& proposal() const { return proposal_; }
  /// Covariance of the current calibration, if it was re-estimated.
  const std::optional<geometry::Matrix6>& covariance() const { return covariance_; }
  bool frozen() const { return frozen_; }
  /// True if the owner has requested a re-estimation that has not started.
  bool recalibration_requested() const { return requested_; }
  /// True if a re-estimation was started and its result is not used yet.
  bool reestimating() const { return state_ == CalibrationState::kRecalibrating; }
  /// Number of scenes that the next re-estimation needs.
  size_t needed_scenes() const { return options_.min_scenes; }
  /// Events, oldest first.
  const std::vector<HistoryEntry>& history() const { return history_; }

 private:
  /// The calibration that an event brings, and what the history says of it.
  struct Subject {
    std::string what;
    Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
    std::optional<geometry::Matrix6> covariance;
    const Reestimate* result = nullptr;
  };

  void apply(CalibrationEvent event, Stamp stamp, const Subject& subject,
             SupervisorActions& actions);
  void set_current(const Eigen::Isometry3d& T, const std::optional<geometry::Matrix6>& covariance,
                   SupervisorActions& actions);
  template <class Change>
  SupervisorActions act(Change change);
  void check_probation(const MonitorReport& report, SupervisorActions& actions);
  void check_proposal(const MonitorReport& report, SupervisorActions& actions);
  void use_result_if_due(const MonitorReport& report, SupervisorActions& actions);
  CalibrationEvent event_of(const Reestimate& result);
  void observe(const MonitorReport& report, SupervisorActions& actions);
  void start_reestimation_if_due(const MonitorReport& report, size_t scenes,
                                 SupervisorActions& actions);
  bool policy_allows(const Reestimate& result) const;
  void add_history(Stamp stamp, std::string what);

  SupervisorOptions options_;
  CalibrationState state_ = CalibrationState::kMonitoring;
  Eigen::Isometry3d current_;
  std::optional<Eigen::Isometry3d> before_;  // the one before, on probation
  std::optional<geometry::Matrix6> covariance_;
  std::optional<Reestimate> proposal_;
  std::optional<Reestimate> result_;  // not used yet
  Stamp reestimation_started_;
  Stamp next_retry_ = Stamp::earliest();
  Stamp moved_again_ = Stamp::earliest();  // after the drift that the last proposal answered
  int failures_ = 0;
  double gain_sum_ = 0;
  int gain_count_ = 0;
  bool requested_ = false;
  bool frozen_ = false;
  bool drift_noted_ = false;
  std::vector<HistoryEntry> history_;
};

}  // namespace infuse::monitoring
