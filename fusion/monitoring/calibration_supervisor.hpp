#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/reestimate.hpp"

namespace infuse::monitoring {

/// How a calibration stands.
enum class CalibrationState : uint8_t {
  kOk,
  kMonitoring,     ///< too little seen yet to say anything
  kSuspected,      ///< evidence for a drift, not enough to be certain
  kConfirmed,      ///< certain; a re-estimation waits for scenes, or its result for the owner
  kRecalibrating,  ///< a re-estimation runs
  kRecalibrated,   ///< a new calibration is in use and on probation
  kUnusable,       ///< the camera is at fault, or re-estimations keep failing: do not use it
};

/// "OK", "MONITORING" …
const char* to_string(CalibrationState state);

/// What may be done with a re-estimated calibration.
enum class UpdatePolicy : uint8_t {
  kAlertOnly,    ///< it is proposed; the owner applies it
  kApply,        ///< it is applied
  kApplyWithin,  ///< it is applied where it moved less than the limits, else proposed
};

/// Settings of the decisions.
struct SupervisorOptions {
  UpdatePolicy policy = UpdatePolicy::kAlertOnly;
  double limit_rotation = 0.05;    ///< rad, of kApplyWithin
  double limit_translation = 0.1;  ///< m, of kApplyWithin
  size_t min_scenes = 30;          ///< kept since the drift began, before a re-estimation starts
  size_t min_scenes_after_timeout = 15;  ///< the same, where it has been certain for `patience`
  double scene_timeout = 40;             ///< s
  double result_delay = 10;        ///< s of drive after its start at which a result becomes visible
  double min_moved = 3.5;          ///< Mahalanobis distance (6 degrees of freedom) below which the
                                   ///< present calibration is kept after all
  int probation_evaluations = 15;  ///< looks that a new calibration is compared with the old one
  int max_failures = 3;            ///< re-estimations without a usable result: unusable
  double retry_interval = 20;      ///< s between re-estimations
  size_t max_history = 64;         ///< entries kept

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// One thing that happened to a calibration.
struct HistoryEntry {
  Stamp stamp;
  CalibrationState state = CalibrationState::kOk;                    ///< after it
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< in use after it
  std::string
      what;  ///< "drift confirmed: rotation about y, 0.52 degrees", "applied", "rolled back: …"
};

/// What is to be done now.
struct SupervisorActions {
  CalibrationState state = CalibrationState::kMonitoring;
  bool state_changed = false;       ///< the state is another than before
  bool start_reestimation = false;  ///< start a re-estimation from the scenes kept since `since`
  Stamp scenes_since;               ///< of `start`
  bool cancel_reestimation =
      false;  ///< the re-estimation that runs is of no use any more: `finish` must not come
  bool calibration_changed =
      false;  ///< `Decision::present()` is another: tell the watch and everyone
  bool alternative_changed = false;  ///< `Decision::alternative()` is another: tell the watch
};

/// Decides over one camera's calibration: a state machine in drive time, deterministic. It is told
/// of looks and of results, and says what to do; it does nothing itself.
///
/// OK ⇄ SUSPECTED ⇄ CONFIRMED by the watch's evidence; CONFIRMED → RECALIBRATING once enough scenes
/// were kept since the drift can have begun; a usable result is proposed or applied (policy). After
/// it was applied the old calibration stays as the alternative that every look is compared with:
/// where the dependence on following scenes is not higher than with the old one, it is rolled back.
/// A camera at fault is UNUSABLE and nothing is re-estimated.
class CalibrationSupervisor {
 public:
  /// `options.invalid()` must be empty.
  CalibrationSupervisor(const Eigen::Isometry3d& T_camera_lidar, const SupervisorOptions& options);

  /// After every picture. `scenes`: how many the store holds since `report.since`.
  SupervisorActions process(const MonitorReport& report, size_t scenes);

  /// The result of the re-estimation that `start` requested; it becomes visible to the first `take`
  /// at or after the start plus the budget.
  void finish_reestimation(const Reestimate& result);

  /// What the owner may do; each comes into effect with the next `take`.
  void request_recalibration() { recalibration_requested_ = true; }
  /// Applies the proposal, if there is one.
  void request_apply() { apply_requested_ = true; }
  /// Back to the calibration before the last.
  void request_roll_back() { roll_back_requested_ = true; }
  /// Frozen: nothing is applied or re-estimated, and what is being re-estimated is given up; the
  /// watch goes on. The owner may still ask for a re-estimation, which is then proposed.
  void set_frozen(bool frozen) { frozen_requested_ = frozen; }

  CalibrationState state() const { return state_; }
  const Eigen::Isometry3d& current() const { return current_; }
  const std::optional<Eigen::Isometry3d>& alternative() const { return alternative_; }
  /// Found and not applied.
  const std::optional<Reestimate>& proposal() const { return proposal_; }
  /// Of the present calibration, where it was re-estimated.
  const std::optional<geometry::Matrix6>& covariance() const { return covariance_; }
  bool frozen() const { return frozen_; }
  /// A re-estimation was started and its result is not visible yet.
  bool reestimating() const { return reestimating_; }
  /// Oldest first.
  const std::vector<HistoryEntry>& history() const { return history_; }

 private:
  void apply_requests(const MonitorReport& report, SupervisorActions& decided);
  void update_state(const MonitorReport& report, SupervisorActions& decided);
  void start_reestimation_if_due(const MonitorReport& report, size_t scenes,
                                 SupervisorActions& decided);
  void use_result_if_due(const MonitorReport& report, SupervisorActions& decided);
  void check_probation(const MonitorReport& report, SupervisorActions& decided);
  void set_current(const Eigen::Isometry3d& T, Stamp stamp, const std::string& what,
                   SupervisorActions& decided);
  void cancel_reestimation(SupervisorActions& decided);
  void revert_to_previous(Stamp stamp, const std::string& why, SupervisorActions& decided);
  bool policy_allows(const Reestimate& result) const;
  void add_history(Stamp stamp, std::string what);

  SupervisorOptions options_;
  CalibrationState state_ = CalibrationState::kMonitoring;
  Eigen::Isometry3d current_;
  std::optional<Eigen::Isometry3d> alternative_;  // the one before, while on probation
  std::optional<Eigen::Isometry3d> previous_;     // the one before, for the owner
  std::optional<geometry::Matrix6> covariance_;
  std::optional<Reestimate> proposal_;
  std::optional<Reestimate> result_;  // not visible yet
  bool reestimating_ = false;
  Stamp reestimation_started_;
  Stamp next_retry_ = Stamp::earliest();
  Stamp confirmed_since_;  // since when that is certain
  int failures_ = 0;
  double gain_sum_ = 0;
  int gain_count_ = 0;
  bool recalibration_requested_ = false, apply_requested_ = false, roll_back_requested_ = false;
  std::optional<bool> frozen_requested_;
  bool frozen_ = false;
  std::vector<HistoryEntry> history_;
};

}  // namespace infuse::monitoring
