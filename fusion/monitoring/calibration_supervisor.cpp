#include "fusion/monitoring/calibration_supervisor.hpp"

#include <algorithm>
#include <utility>

#include "fusion/monitoring/format_text.hpp"

namespace infuse::monitoring {

std::optional<std::string> SupervisorOptions::invalid() const {
  if (!(limit_rotation > 0) || !(limit_translation > 0)) return "limits must be positive";
  if (min_scenes < 3) return "min_scenes must be at least 3";
  if (!(result_delay >= 0) || !(retry_interval >= 0))
    return "result_delay and retry_interval must not be negative";
  if (!(min_moved >= 0)) return "min_moved must not be negative";
  if (probation_evaluations < 1 || max_failures < 1)
    return "probation_evaluations and max_failures must be at least 1";
  if (max_history < 1) return "max_history must be at least 1";
  return std::nullopt;
}

CalibrationSupervisor::CalibrationSupervisor(const Eigen::Isometry3d& T_camera_lidar,
                                             const SupervisorOptions& options)
    : options_(options), current_(T_camera_lidar) {
  history_.reserve(options.max_history + 1);
}

void CalibrationSupervisor::add_history(Stamp stamp, std::string what) {
  if (history_.size() == options_.max_history) history_.erase(history_.begin());
  history_.push_back({stamp, state_, current_, std::move(what)});
}

void CalibrationSupervisor::finish_reestimation(const Reestimate& result) {
  const bool same = result.T_initial.matrix() == current_.matrix();
  if (reestimating() && same) result_ = result;
}

bool CalibrationSupervisor::policy_allows(const Reestimate& result) const {
  if (frozen_ || options_.policy == UpdatePolicy::kAlertOnly) return false;
  if (options_.policy == UpdatePolicy::kApply) return true;
  const geometry::Vector6 moved = geometry::log(result.T_camera_lidar * current_.inverse());
  return moved.head<3>().norm() <= options_.limit_rotation &&
         moved.tail<3>().norm() <= options_.limit_translation;
}

std::optional<Eigen::Isometry3d> CalibrationSupervisor::alternative() const {
  if (before_) return before_;
  if (proposal_) return proposal_->T_camera_lidar;
  return std::nullopt;
}

void CalibrationSupervisor::set_current(const Eigen::Isometry3d& T,
                                        const std::optional<geometry::Matrix6>& covariance,
                                        SupervisorActions& actions) {
  before_ = current_;
  current_ = T;
  covariance_ = covariance;
  requested_ = false;
  gain_sum_ = gain_count_ = 0;
  moved_again_ = Stamp::earliest();
  actions.calibration_changed = true;
}

/// Performs the transition of an event.
void CalibrationSupervisor::apply(CalibrationEvent event, Stamp stamp, const Subject& subject,
                                  SupervisorActions& actions) {
  const CalibrationTransition done = transition(state_, event);
  if (done.does(kCancel) && reestimating()) actions.cancel_reestimation = true;
  if (done.does(kCancel)) result_.reset();
  if (done.does(kWithdraw)) proposal_.reset();
  if (done.does(kForgetFailures)) failures_ = 0;
  if (done.does(kWant)) requested_ = true;
  if (done.does(kPropose)) proposal_ = *subject.result;
  if (done.does(kStart)) {
    requested_ = false;
    reestimation_started_ = stamp;
    actions.start_reestimation = true;
  }
  if (done.does(kUse)) set_current(subject.T_camera_lidar, subject.covariance, actions);
  if (done.does(kRevert)) {
    set_current(Eigen::Isometry3d(*before_), std::nullopt, actions);
    next_retry_ = stamp + from_seconds(options_.retry_interval);
  }
  if (done.does(kRestartEvidence)) actions.calibration_changed = true;
  state_ = done.state;
  if (state_ != CalibrationState::kRecalibrated) before_.reset();
  if (state_ == CalibrationState::kOk || done.does(kUse)) drift_noted_ = false;
  if (!done.does(kNote) || (event == CalibrationEvent::kConfirmed && drift_noted_)) return;
  drift_noted_ = drift_noted_ || event == CalibrationEvent::kConfirmed;
  add_history(stamp, subject.what);
}

/// Performs a change and returns what it did.
template <class Change>
SupervisorActions CalibrationSupervisor::act(Change change) {
  SupervisorActions actions;
  const CalibrationState before = state_;
  const std::optional<Eigen::Isometry3d> other = alternative();
  change(actions);
  const std::optional<Eigen::Isometry3d> now = alternative();
  actions.state = state_;
  actions.state_changed = state_ != before;
  actions.alternative_changed =
      now.has_value() != other.has_value() || (now && now->matrix() != other->matrix());
  return actions;
}

SupervisorActions CalibrationSupervisor::request_recalibration(Stamp stamp) {
  return act([&](SupervisorActions& actions) {
    apply(CalibrationEvent::kOwnerRecalibrates, stamp, {}, actions);
    next_retry_ = std::min(next_retry_, stamp);
  });
}

SupervisorActions CalibrationSupervisor::use(const OwnerCalibration& calibration, Stamp stamp) {
  return act([&](SupervisorActions& actions) {
    const bool back = calibration.rolls_back;
    apply(back ? CalibrationEvent::kOwnerRollsBack : CalibrationEvent::kOwnerApplies, stamp,
          {.what = back ? "rolled back: requested" : "applied: requested",
           .T_camera_lidar = calibration.T_camera_lidar,
           .covariance = calibration.covariance},
          actions);
    if (frozen_) apply(CalibrationEvent::kOwnerFreezes, stamp, {}, actions);  // no probation
    if (back) next_retry_ = stamp + from_seconds(options_.retry_interval);
  });
}

SupervisorActions CalibrationSupervisor::freeze(bool frozen, Stamp stamp) {
  return act([&](SupervisorActions& actions) {
    frozen_ = frozen;
    if (frozen) apply(CalibrationEvent::kOwnerFreezes, stamp, {}, actions);
  });
}

void CalibrationSupervisor::check_probation(const MonitorReport& report,
                                            SupervisorActions& actions) {
  if (!before_ || !report.has_gain || !report.evaluated) return;
  gain_sum_ += report.gain;
  ++gain_count_;
  if (gain_count_ < options_.probation_evaluations) return;
  if (gain_sum_ > 0) {
    return apply(CalibrationEvent::kProbationPassed, report.stamp,
                 {.what = "new calibration confirmed by later scenes"}, actions);
  }
  apply(CalibrationEvent::kProbationFailed, report.stamp,
        {.what = "rolled back: later scenes fit the old calibration better"}, actions);
}

void CalibrationSupervisor::check_proposal(const MonitorReport& report,
                                           SupervisorActions& actions) {
  if (before_ || !proposal_ || !report.alternative_drifted) return;
  moved_again_ = report.alternative_since;
  apply(CalibrationEvent::kProposalOutdated, report.stamp,
        {.what = "proposal withdrawn: later scenes contradict it"}, actions);
}

CalibrationEvent CalibrationSupervisor::event_of(const Reestimate& result) {
  if (!result.usable()) {
    ++failures_;
    return failures_ >= options_.max_failures ? CalibrationEvent::kResultFailedLast
                                              : CalibrationEvent::kResultFailed;
  }
  if (result.moved < options_.min_moved) return CalibrationEvent::kResultUnmoved;
  return policy_allows(result) ? CalibrationEvent::kResultAllowed
                               : CalibrationEvent::kResultProposed;
}

void CalibrationSupervisor::use_result_if_due(const MonitorReport& report,
                                              SupervisorActions& actions) {
  if (!result_ || report.stamp < reestimation_started_ + from_seconds(options_.result_delay))
    return;
  const Reestimate result = *std::exchange(result_, std::nullopt);
  next_retry_ = report.stamp + from_seconds(options_.retry_interval);
  const CalibrationEvent event = event_of(result);
  std::string what = "not re-estimated: " + result.reason;
  if (event == CalibrationEvent::kResultUnmoved) {
    what = format_text("re-estimated: moved by %.1f standard deviations, not significantly",
                       result.moved);
  } else if (event == CalibrationEvent::kResultAllowed) {
    what =
        format_text("new calibration applied: moved by %.1f standard deviations, from %zu scenes",
                    result.moved, result.scenes);
  } else if (event == CalibrationEvent::kResultProposed) {
    what = "proposed: the policy does not apply it";
  }
  apply(event, report.stamp, {what, result.T_camera_lidar, result.covariance, &result}, actions);
}

/// Follows what the image says of the calibration in use.
void CalibrationSupervisor::observe(const MonitorReport& report, SupervisorActions& actions) {
  constexpr double kHoldsBelow = 1;  // nats: odds of e
  const DriftVerdict& verdict = report.verdict;
  if (verdict.fault != CameraFault::kNone) {
    return apply(CalibrationEvent::kFault, report.stamp,
                 {.what = "the camera has a fault: " + describe_fault(verdict)}, actions);
  }
  if (failures_ >= options_.max_failures) {
    return apply(CalibrationEvent::kGivenUp, report.stamp, {}, actions);
  }
  switch (verdict.drift) {
    case Drift::kLearning:
      return apply(CalibrationEvent::kLearning, report.stamp, {}, actions);
    case Drift::kHolds:
      return apply(
          verdict.evidence < kHoldsBelow ? CalibrationEvent::kHolds : CalibrationEvent::kDoubted,
          report.stamp, {}, actions);
    case Drift::kSuspected:
      return apply(CalibrationEvent::kSuspected, report.stamp, {}, actions);
    case Drift::kConfirmed:
      return apply(CalibrationEvent::kConfirmed, report.stamp,
                   {.what = "drift confirmed: " + describe_drift(verdict)}, actions);
  }
}

void CalibrationSupervisor::start_reestimation_if_due(const MonitorReport& report, size_t scenes,
                                                      SupervisorActions& actions) {
  const bool wanted =
      requested_ || (state_ == CalibrationState::kConfirmed && !proposal_ && !frozen_);
  if (!wanted || scenes < needed_scenes() || report.stamp < next_retry_) return;
  actions.scenes_since = scenes_since(report);
  apply(CalibrationEvent::kScenesReady, report.stamp, {}, actions);
}

SupervisorActions CalibrationSupervisor::process(const MonitorReport& report, size_t scenes) {
  return act([&](SupervisorActions& actions) {
    check_probation(report, actions);
    check_proposal(report, actions);
    // A report from before the change does not apply to the new calibration.
    if (actions.calibration_changed) return;
    use_result_if_due(report, actions);
    if (actions.calibration_changed) return;
    observe(report, actions);
    start_reestimation_if_due(report, scenes, actions);
  });
}

}  // namespace infuse::monitoring
