#include "daemon/calibration/guard.hpp"

namespace infuse::daemon {
namespace {

const char* name_of(watch::Policy policy) {
  switch (policy) {
    case watch::Policy::kAlertOnly:
      return "alert-only";
    case watch::Policy::kApply:
      return "apply";
    case watch::Policy::kApplyWithin:
      return "apply-within";
  }
  return "";
}

}  // namespace

CalibrationGuard::CalibrationGuard(const CameraMount& mount, const CalibrationSettings& settings,
                                   bool waits)
    : intrinsics_(mount.intrinsics),
      settings_(settings),
      watch_(mount.intrinsics, mount.T_camera_lidar, settings.watch),
      decision_(mount.T_camera_lidar, settings.decision),
      background_(waits) {
  report_.camera = mount.name;
  report_.policy = name_of(settings.decision.policy);
  report_.state = watch::to_string(decision_.state());
}

bool CalibrationGuard::take(const CameraFrame& grey, const watch::SweepView& sweep,
                            const watch::Motion& motion) {
  const Stamp now = grey.stamp;
  if (background_.take(now)) {
    last_ = result_;
    decision_.finish(result_);
  }
  const watch::WatchReport seen = watch_.take(grey, sweep, motion);
  looks_ += seen.looked ? 1 : 0;
  // None to start with while one that was cancelled has not ended.
  const size_t scenes =
      decision_.running() || !background_.busy() ? watch_.scenes().count_since(seen.since) : 0;
  const watch::Decided decided = decision_.take(seen, scenes);
  if (decided.cancel) background_.cancel();
  if (decided.calibration_changed) watch_.set_calibration(decision_.present());
  if (decided.alternative_changed) watch_.set_alternative(decision_.alternative());
  if (decided.start) start(decided, now);
  const bool changed = decided.changed || decided.calibration_changed;
  if (!changed && told_ && now - *told_ < kTellEvery && now >= *told_) return false;
  if (changed || !told_) report_.since = now;
  told_ = now;
  fill_report(seen);
  return true;
}

void CalibrationGuard::start(const watch::Decided& decided, Stamp now) {
  watch_.scenes().copy(decided.since, scenes_);
  background_.start(now, from_seconds(settings_.decision.budget),
                    [this, present = decision_.present()](std::stop_token stop) {
                      result_ = watch::reestimate(scenes_, intrinsics_, present,
                                                  settings_.reestimate, stop);
                    });
}

void CalibrationGuard::obey(const Request& request) {
  if (request.op == Request::Op::kRecalibrate) decision_.recalibrate();
  if (request.op == Request::Op::kApply) decision_.apply();
  if (request.op == Request::Op::kRollback) decision_.roll_back();
  if (request.op == Request::Op::kFreeze) decision_.freeze(request.on);
}

void CalibrationGuard::fill_report(const watch::WatchReport& seen) {
  report_.stamp = seen.stamp;
  report_.state = watch::to_string(decision_.state());
  report_.frozen = decision_.frozen();
  report_.T_camera_lidar = decision_.present();
  report_.looks = looks_;
  report_.scenes = watch_.scenes().size();
  report_.axis = looks_ > 0 ? watch::to_string(seen.axis) : "";
  report_.evidence = seen.evidence;
  report_.evidence_needed = settings_.watch.test.certain();
  report_.offset = seen.offset;
  report_.deviation = seen.deviation;
  report_.delay = seen.delay;
  report_.delay_alike = seen.delay_alike ? watch::to_string(*seen.delay_alike) : "";
  if (seen.looked) report_.dependence = seen.dependence;
  report_.fault = seen.fault == watch::CameraFault::kNone ? "" : watch::to_string(seen.fault);
  report_.has_estimate = last_.has_value();
  if (last_) {
    report_.T_camera_lidar_estimate = last_->T_camera_lidar;
    report_.covariance = last_->covariance;
    report_.moved = last_->moved;
    report_.estimate_scenes = last_->scenes;
    report_.estimate_reason = last_->reason;
  }
  report_.history.clear();
  for (const watch::HistoryEntry& entry : decision_.history()) {
    report_.history.push_back(
        {entry.stamp, watch::to_string(entry.state), entry.what, entry.T_camera_lidar});
  }
}

}  // namespace infuse::daemon
