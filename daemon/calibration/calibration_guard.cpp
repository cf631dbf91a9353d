#include "daemon/calibration/calibration_guard.hpp"

namespace infuse::daemon {

CalibrationGuard::CalibrationGuard(const CameraMount& mount, const CalibrationSettings& settings,
                                   bool blocking)
    : intrinsics_(mount.intrinsics),
      settings_(settings),
      monitor_(mount.intrinsics, mount.T_camera_lidar, settings.monitor),
      supervisor_(mount.T_camera_lidar, settings.supervisor),
      background_(blocking) {
  report_.camera = mount.name;
  report_.policy = settings.supervisor.policy;
  report_.state = supervisor_.state();
}

const CalibrationReport* CalibrationGuard::process(const CameraFrame& grey,
                                                   const monitoring::SweepView& sweep,
                                                   const monitoring::Motion& motion) {
  const Stamp now = grey.stamp;
  if (background_.consume_result(now)) {
    last_result_ = result_;
    supervisor_.finish_reestimation(result_);
  }
  const monitoring::MonitorReport monitor_report = monitor_.process(grey, sweep, motion);
  evaluations_ += monitor_report.evaluated ? 1 : 0;
  // No scenes for a new re-estimation while a cancelled one still runs.
  const size_t scenes = supervisor_.reestimating() || !background_.busy()
                            ? monitor_.scenes().count_since(monitor_report.since)
                            : 0;
  const monitoring::SupervisorActions actions = supervisor_.process(monitor_report, scenes);
  if (actions.cancel_reestimation) background_.cancel();
  if (actions.calibration_changed) monitor_.set_calibration(supervisor_.current());
  if (actions.alternative_changed) monitor_.set_alternative(supervisor_.alternative());
  if (actions.start_reestimation) start_reestimation(actions, now);
  const bool changed = actions.state_changed || actions.calibration_changed;
  if (!changed && reported_at_ && now - *reported_at_ < kReportInterval && now >= *reported_at_) {
    return nullptr;
  }
  if (changed || !reported_at_) report_.since = now;
  reported_at_ = now;
  fill_report(monitor_report);
  return &report_;
}

void CalibrationGuard::start_reestimation(const monitoring::SupervisorActions& actions, Stamp now) {
  monitor_.scenes().copy(actions.scenes_since, scenes_);
  background_.start(now, from_seconds(settings_.supervisor.result_delay),
                    [this, present = supervisor_.current()](std::stop_token stop) {
                      result_ = monitoring::reestimate(scenes_, intrinsics_, present,
                                                       settings_.reestimate, stop);
                    });
}

void CalibrationGuard::handle_request(const Request& request) {
  if (request.op == Request::Op::kRecalibrate) supervisor_.request_recalibration();
  if (request.op == Request::Op::kApply) supervisor_.request_apply();
  if (request.op == Request::Op::kRollback) supervisor_.request_roll_back();
  if (request.op == Request::Op::kFreeze) supervisor_.set_frozen(request.on);
}

void CalibrationGuard::fill_report(const monitoring::MonitorReport& monitor_report) {
  report_.stamp = monitor_report.stamp;
  report_.state = supervisor_.state();
  report_.frozen = supervisor_.frozen();
  report_.proposed = supervisor_.proposal().has_value();
  report_.can_roll_back = supervisor_.can_roll_back();
  report_.T_camera_lidar = supervisor_.current();
  report_.evaluations = evaluations_;
  report_.scenes = monitor_.scenes().size();
  report_.verdict = monitor_report.verdict;
  if (monitor_report.evaluated) report_.dependence = monitor_report.dependence;
  if (last_result_) {
    report_.estimate = {last_result_->T_camera_lidar, last_result_->covariance, last_result_->moved,
                        last_result_->scenes, last_result_->reason};
  }
  report_.history.clear();
  for (const monitoring::HistoryEntry& entry : supervisor_.history()) {
    report_.history.push_back({entry.stamp, entry.state, entry.what, entry.T_camera_lidar});
  }
}

}  // namespace infuse::daemon
