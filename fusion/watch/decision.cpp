#include "fusion/watch/decision.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace infuse::watch {
namespace {

constexpr double kDegrees = 180 / M_PI;

template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

/// "rotation about y, -0.52 degrees"
std::string what_moved(const WatchReport& report) {
  if (report.axis == Axis::kTime) {
    return print("stamps, %.0f ms late", 1e3 * report.delay) +
           (report.delay_alike ? print(" (or %s: not to be told apart as it drove)",
                                       to_string(*report.delay_alike))
                               : "");
  }
  const auto k = static_cast<Eigen::Index>(report.axis);
  const std::string moved =
      k < 3 ? print("%s, %.2f degrees", to_string(report.axis), report.offset(k) * kDegrees)
            : print("%s, %.1f cm", to_string(report.axis), 100 * report.offset(k));
  return moved + (report.delay_alike == report.axis
                      ? " (or late stamps: not to be told apart as it drove)"
                      : "");
}

}  // namespace

const char* to_string(CalibrationState state) {
  constexpr std::array<const char*, 7> kNames = {
      "OK", "WATCHING", "SUSPECT", "DRIFTED", "RECALIBRATING", "RECALIBRATED", "UNUSABLE"};
  return kNames[static_cast<size_t>(state)];
}

std::optional<std::string> DecisionOptions::invalid() const {
  if (!(limit_rotation > 0) || !(limit_translation > 0)) return "limits must be positive";
  if (least_scenes < 3 || scenes < least_scenes) return "3 <= least_scenes <= scenes must hold";
  if (!(budget >= 0) || !(retry >= 0) || !(patience >= 0)) {
    return "budget, retry and patience must not be negative";
  }
  if (!(least_moved >= 0)) return "least_moved must not be negative";
  if (probation < 1 || failures < 1) return "probation and failures must be at least 1";
  if (history < 1) return "history must be at least 1";
  return std::nullopt;
}

Decision::Decision(const Eigen::Isometry3d& T_camera_lidar, const DecisionOptions& options)
    : options_(options), present_(T_camera_lidar) {
  history_.reserve(options.history + 1);
}

void Decision::note(Stamp stamp, std::string what) {
  if (history_.size() == options_.history) history_.erase(history_.begin());
  history_.push_back({stamp, state_, present_, std::move(what)});
}

void Decision::finish(const Reestimate& result) { result_ = result; }

bool Decision::may_apply(const Reestimate& result) const {
  if (frozen_ || options_.policy == Policy::kAlertOnly) return false;
  if (options_.policy == Policy::kApply) return true;
  const geometry::Vector6 moved = geometry::log(result.T_camera_lidar * present_.inverse());
  return moved.head<3>().norm() <= options_.limit_rotation &&
         moved.tail<3>().norm() <= options_.limit_translation;
}

void Decision::use(const Eigen::Isometry3d& T, Stamp stamp, const std::string& what,
                   Decided& decided) {
  previous_ = present_;
  present_ = T;
  decided.calibration_changed = true;
  note(stamp, what);
}

void Decision::go_back(Stamp stamp, const std::string& why, Decided& decided) {
  if (!previous_) return;
  alternative_.reset();
  decided.alternative_changed = true;
  covariance_.reset();
  state_ = CalibrationState::kSuspect;
  use(Eigen::Isometry3d(*previous_), stamp, "rolled back: " + why, decided);
  retry_ = stamp + from_seconds(options_.retry);
}

/// The re-estimation that runs, if one does.
void Decision::give_up(Decided& decided) {
  if (!std::exchange(running_, false)) return;
  result_.reset();
  decided.cancel = true;
  if (state_ == CalibrationState::kRecalibrating) state_ = CalibrationState::kDrifted;
}

/// What the owner asked for.
void Decision::obey(const WatchReport& report, Decided& decided) {
  if (asked_frozen_) {
    frozen_ = *std::exchange(asked_frozen_, std::nullopt);
    if (frozen_) give_up(decided);
  }
  if (std::exchange(asked_roll_back_, false)) {
    give_up(decided);
    go_back(report.stamp, "asked for", decided);
  }
  if (std::exchange(asked_apply_, false) && proposal_) {
    give_up(decided);
    state_ = CalibrationState::kRecalibrated;
    alternative_ = present_;
    decided.alternative_changed = true;
    covariance_ = proposal_->covariance;
    use(Eigen::Isometry3d(proposal_->T_camera_lidar), report.stamp, "applied: asked for", decided);
    proposal_.reset();
    gain_ = gains_ = 0;
  }
}

void Decision::follow_evidence(const WatchReport& report, Decided& decided) {
  const CalibrationState before = state_;
  const bool at_fault = report.fault != CameraFault::kNone;
  if (at_fault) give_up(decided);
  switch (state_) {
    case CalibrationState::kRecalibrating:
    case CalibrationState::kRecalibrated:
      if (at_fault) state_ = CalibrationState::kUnusable;
      break;
    case CalibrationState::kUnusable:
      if (at_fault || failed_ >= options_.failures) break;
      state_ = CalibrationState::kWatching;
      [[fallthrough]];
    default:
      if (at_fault) {
        state_ = CalibrationState::kUnusable;
      } else if (report.drift == Drift::kDrifted) {
        state_ = CalibrationState::kDrifted;
      } else if (report.drift == Drift::kSuspect) {
        // What was certain stays so until the evidence is gone.
        if (state_ != CalibrationState::kDrifted) state_ = CalibrationState::kSuspect;
      } else if (report.drift == Drift::kHolds) {
        if (report.evidence < 1 || state_ == CalibrationState::kWatching) {
          state_ = CalibrationState::kOk;
        }
      } else {
        state_ = CalibrationState::kWatching;
      }
  }
  if (state_ == before) return;
  if (state_ == CalibrationState::kDrifted) {
    drifted_ = report.stamp;
    note(report.stamp, "drifted: " + what_moved(report));
  }
  if (state_ == CalibrationState::kUnusable) {
    note(report.stamp, std::string("the camera is at fault: ") + to_string(report.fault) +
                           (report.fault == CameraFault::kLate ? ": " + what_moved(report) : ""));
  }
}

void Decision::maybe_start(const WatchReport& report, size_t scenes, Decided& decided) {
  const bool wanted =
      asked_recalibrate_ || (state_ == CalibrationState::kDrifted && !proposal_ && !frozen_);
  const bool waited = state_ == CalibrationState::kDrifted &&
                      report.stamp - drifted_ >= from_seconds(options_.patience);
  const size_t enough = waited ? options_.least_scenes : options_.scenes;
  if (!wanted || running_ || state_ == CalibrationState::kUnusable || scenes < enough ||
      report.stamp < retry_) {
    return;
  }
  asked_recalibrate_ = false;
  running_ = true;
  started_ = report.stamp;
  state_ = CalibrationState::kRecalibrating;
  decided.start = true;
  decided.since = report.since;
}

void Decision::maybe_finish(const WatchReport& report, Decided& decided) {
  if (!running_ || !result_ || report.stamp < started_ + from_seconds(options_.budget)) return;
  const Reestimate result = *std::exchange(result_, std::nullopt);
  running_ = false;
  retry_ = report.stamp + from_seconds(options_.retry);
  if (!result.usable()) {
    ++failed_;
    state_ =
        failed_ >= options_.failures ? CalibrationState::kUnusable : CalibrationState::kDrifted;
    note(report.stamp, "not re-estimated: " + result.reason);
  } else if (result.moved < options_.least_moved) {
    failed_ = 0;
    state_ = CalibrationState::kOk;
    decided.calibration_changed = true;  // evidence starts anew
    note(report.stamp, print("re-estimated: it has not moved (%.1f deviations)", result.moved));
  } else if (may_apply(result)) {
    failed_ = 0;
    state_ = CalibrationState::kRecalibrated;
    alternative_ = present_;
    decided.alternative_changed = true;
    covariance_ = result.covariance;
    gain_ = gains_ = 0;
    use(result.T_camera_lidar, report.stamp,
        print("applied: moved by %.1f deviations, %zu scenes", result.moved, result.scenes),
        decided);
  } else {
    failed_ = 0;
    state_ = CalibrationState::kDrifted;
    proposal_ = result;
    note(report.stamp, "proposed: the policy does not apply it");
  }
}

void Decision::watch_probation(const WatchReport& report, Decided& decided) {
  if (state_ != CalibrationState::kRecalibrated || !report.has_gain || !report.looked) return;
  gain_ += report.gain;
  ++gains_;
  if (gains_ < options_.probation) return;
  if (gain_ <= 0) {
    go_back(report.stamp, "following scenes fit the old calibration better", decided);
    return;
  }
  alternative_.reset();
  decided.alternative_changed = true;
  state_ = CalibrationState::kOk;
  note(report.stamp, "confirmed by following scenes");
}

Decided Decision::take(const WatchReport& report, size_t scenes) {
  Decided decided;
  const CalibrationState before = state_;
  obey(report, decided);
  watch_probation(report, decided);
  // A report made before the calibration changed says nothing of the new one.
  if (!decided.calibration_changed) {
    maybe_finish(report, decided);
    if (!decided.calibration_changed) {
      follow_evidence(report, decided);
      maybe_start(report, scenes, decided);
    }
  }
  decided.state = state_;
  decided.changed = state_ != before;
  return decided;
}

}  // namespace infuse::watch
