#include "fusion/monitoring/calibration_supervisor.hpp"

#include <array>
#include <utility>

#include "fusion/monitoring/format_text.hpp"

namespace infuse::monitoring {

const char* name_of(CalibrationState state) {
  constexpr std::array<const char*, 7> kNames = {
      "OK", "MONITORING", "SUSPECTED", "CONFIRMED", "RECALIBRATING", "RECALIBRATED", "UNUSABLE"};
  return kNames[static_cast<size_t>(state)];
}

std::optional<std::string> SupervisorOptions::invalid() const {
  if (!(limit_rotation > 0) || !(limit_translation > 0)) return "limits must be positive";
  if (min_scenes_after_timeout < 3 || min_scenes < min_scenes_after_timeout)
    return "3 <= min_scenes_after_timeout <= min_scenes must hold";
  if (!(result_delay >= 0) || !(retry_interval >= 0) || !(scene_timeout >= 0)) {
    return "result_delay, retry_interval and scene_timeout must not be negative";
  }
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

void CalibrationSupervisor::finish_reestimation(const Reestimate& result) { result_ = result; }

bool CalibrationSupervisor::policy_allows(const Reestimate& result) const {
  if (frozen_ || options_.policy == UpdatePolicy::kAlertOnly) return false;
  if (options_.policy == UpdatePolicy::kApply) return true;
  const geometry::Vector6 moved = geometry::log(result.T_camera_lidar * current_.inverse());
  return moved.head<3>().norm() <= options_.limit_rotation &&
         moved.tail<3>().norm() <= options_.limit_translation;
}

void CalibrationSupervisor::set_current(const Eigen::Isometry3d& T, Stamp stamp,
                                        const std::string& what, SupervisorActions& actions) {
  previous_ = current_;
  current_ = T;
  actions.calibration_changed = true;
  add_history(stamp, what);
}

void CalibrationSupervisor::revert_to_previous(Stamp stamp, const std::string& cause,
                                               SupervisorActions& actions) {
  if (!previous_) return;
  alternative_.reset();
  actions.alternative_changed = true;
  covariance_.reset();
  state_ = CalibrationState::kSuspected;
  set_current(Eigen::Isometry3d(*previous_), stamp, "rolled back: " + cause, actions);
  next_retry_ = stamp + from_seconds(options_.retry_interval);
}

/// Cancels the running re-estimation, if any.
void CalibrationSupervisor::cancel_reestimation(SupervisorActions& actions) {
  if (!std::exchange(reestimating_, false)) return;
  result_.reset();
  actions.cancel_reestimation = true;
  if (state_ == CalibrationState::kRecalibrating) state_ = CalibrationState::kConfirmed;
}

/// Applies the owner's requests.
void CalibrationSupervisor::apply_requests(const MonitorReport& report,
                                           SupervisorActions& actions) {
  if (frozen_requested_) {
    frozen_ = *std::exchange(frozen_requested_, std::nullopt);
    if (frozen_) cancel_reestimation(actions);
  }
  if (std::exchange(roll_back_requested_, false)) {
    cancel_reestimation(actions);
    revert_to_previous(report.stamp, "requested", actions);
  }
  if (std::exchange(apply_requested_, false) && proposal_) {
    cancel_reestimation(actions);
    state_ = CalibrationState::kRecalibrated;
    alternative_ = current_;
    actions.alternative_changed = true;
    covariance_ = proposal_->covariance;
    set_current(Eigen::Isometry3d(proposal_->T_camera_lidar), report.stamp, "applied: requested",
                actions);
    proposal_.reset();
    gain_sum_ = gain_count_ = 0;
  }
}

void CalibrationSupervisor::update_state(const MonitorReport& report, SupervisorActions& actions) {
  const DriftVerdict& verdict = report.verdict;
  const CalibrationState before = state_;
  const bool at_fault = verdict.fault != CameraFault::kNone;
  if (at_fault) cancel_reestimation(actions);
  switch (state_) {
    case CalibrationState::kRecalibrating:
    case CalibrationState::kRecalibrated:
      if (at_fault) state_ = CalibrationState::kUnusable;
      break;
    case CalibrationState::kUnusable:
      if (at_fault || failures_ >= options_.max_failures) break;
      state_ = CalibrationState::kMonitoring;
      [[fallthrough]];
    default:
      if (at_fault) {
        state_ = CalibrationState::kUnusable;
      } else if (verdict.drift == Drift::kConfirmed) {
        state_ = CalibrationState::kConfirmed;
      } else if (verdict.drift == Drift::kSuspected) {
        // A confirmed drift stays confirmed until the evidence is gone.
        if (state_ != CalibrationState::kConfirmed) state_ = CalibrationState::kSuspected;
      } else if (verdict.drift == Drift::kHolds) {
        if (verdict.evidence < 1 || state_ == CalibrationState::kMonitoring) {
          state_ = CalibrationState::kOk;
        }
      } else {
        state_ = CalibrationState::kMonitoring;
      }
  }
  if (state_ == before) return;
  if (state_ == CalibrationState::kConfirmed) {
    confirmed_since_ = report.stamp;
    add_history(report.stamp, "drift confirmed: " + describe_drift(verdict));
  }
  if (state_ == CalibrationState::kUnusable) {
    add_history(report.stamp,
                std::string("the camera has a fault: ") + name_of(verdict.fault) +
                    (verdict.fault == CameraFault::kLate ? ": " + describe_drift(verdict) : ""));
  }
}

void CalibrationSupervisor::start_reestimation_if_due(const MonitorReport& report, size_t scenes,
                                                      SupervisorActions& actions) {
  const bool wanted = recalibration_requested_ ||
                      (state_ == CalibrationState::kConfirmed && !proposal_ && !frozen_);
  const bool timed_out = state_ == CalibrationState::kConfirmed &&
                         report.stamp - confirmed_since_ >= from_seconds(options_.scene_timeout);
  const size_t min_scenes = timed_out ? options_.min_scenes_after_timeout : options_.min_scenes;
  if (!wanted || reestimating_ || state_ == CalibrationState::kUnusable || scenes < min_scenes ||
      report.stamp < next_retry_) {
    return;
  }
  recalibration_requested_ = false;
  reestimating_ = true;
  reestimation_started_ = report.stamp;
  state_ = CalibrationState::kRecalibrating;
  actions.start_reestimation = true;
  actions.scenes_since = report.since;
}

void CalibrationSupervisor::use_result_if_due(const MonitorReport& report,
                                              SupervisorActions& actions) {
  if (!reestimating_ || !result_ ||
      report.stamp < reestimation_started_ + from_seconds(options_.result_delay))
    return;
  const Reestimate result = *std::exchange(result_, std::nullopt);
  reestimating_ = false;
  next_retry_ = report.stamp + from_seconds(options_.retry_interval);
  if (!result.usable()) {
    ++failures_;
    state_ = failures_ >= options_.max_failures ? CalibrationState::kUnusable
                                                : CalibrationState::kConfirmed;
    add_history(report.stamp, "not re-estimated: " + result.reason);
  } else if (result.moved < options_.min_moved) {
    failures_ = 0;
    state_ = CalibrationState::kOk;
    actions.calibration_changed = true;  // restarts the evidence
    add_history(report.stamp,
                format_text("re-estimated: not moved significantly (%.1f sigma)", result.moved));
  } else if (policy_allows(result)) {
    failures_ = 0;
    state_ = CalibrationState::kRecalibrated;
    alternative_ = current_;
    actions.alternative_changed = true;
    covariance_ = result.covariance;
    gain_sum_ = gain_count_ = 0;
    set_current(
        result.T_camera_lidar, report.stamp,
        format_text("applied: moved by %.1f sigma, %zu scenes", result.moved, result.scenes),
        actions);
  } else {
    failures_ = 0;
    state_ = CalibrationState::kConfirmed;
    proposal_ = result;
    add_history(report.stamp, "proposed: the policy does not apply it");
  }
}

void CalibrationSupervisor::check_probation(const MonitorReport& report,
                                            SupervisorActions& actions) {
  if (state_ != CalibrationState::kRecalibrated || !report.has_gain || !report.evaluated) return;
  gain_sum_ += report.gain;
  ++gain_count_;
  if (gain_count_ < options_.probation_evaluations) return;
  if (gain_sum_ <= 0) {
    revert_to_previous(report.stamp, "following scenes fit the old calibration better", actions);
    return;
  }
  alternative_.reset();
  actions.alternative_changed = true;
  state_ = CalibrationState::kOk;
  add_history(report.stamp, "confirmed by following scenes");
}

SupervisorActions CalibrationSupervisor::process(const MonitorReport& report, size_t scenes) {
  SupervisorActions actions;
  const CalibrationState before = state_;
  apply_requests(report, actions);
  check_probation(report, actions);
  // A report from before the change does not apply to the new calibration.
  if (!actions.calibration_changed) {
    use_result_if_due(report, actions);
    if (!actions.calibration_changed) {
      update_state(report, actions);
      start_reestimation_if_due(report, scenes, actions);
    }
  }
  actions.state = state_;
  actions.state_changed = state_ != before;
  return actions;
}

}  // namespace infuse::monitoring
