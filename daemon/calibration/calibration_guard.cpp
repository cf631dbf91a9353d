#include "daemon/calibration/calibration_guard.hpp"

#include <mutex>

namespace infuse::daemon {
namespace {

std::optional<CalibrationEstimate> estimate_of(const std::optional<monitoring::Reestimate>& from) {
  if (!from) return std::nullopt;
  return CalibrationEstimate{from->T_camera_lidar, from->covariance, from->moved,
                             from->scenes,         from->reason,     from->T_initial};
}

/// Of drive time; a search takes a few tenths of a second of a processor.
constexpr double kSearchDelay = 0.5;  // s

monitoring::MonitorOptions searching_in_background(monitoring::MonitorOptions options) {
  options.background_search = true;
  return options;
}

/// Held while a re-estimation runs: those of several cameras run one after the other, in the memory
/// of one.
std::mutex& turn() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

CalibrationGuard::CalibrationGuard(const CameraMount& mount, const CalibrationSettings& settings,
                                   bool blocking)
    : intrinsics_(mount.intrinsics),
      settings_(settings),
      monitor_(mount.intrinsics, mount.T_camera_lidar, searching_in_background(settings.monitor)),
      supervisor_(mount.T_camera_lidar, settings.supervisor),
      search_(blocking),
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
  if (!background_.busy()) monitor_.scenes().end_lending();
  if (search_.consume_result(now)) monitor_.finish_search();
  observed_ = monitor_.process(grey, sweep, motion);
  search_drift(now);
  if (observed_.evaluated) {
    ++evaluations_;
    dependence_ = observed_.dependence;
  }
  // No scenes for a new re-estimation while a cancelled one still runs.
  const size_t scenes = supervisor_.reestimating() || !background_.busy()
                            ? monitor_.scenes().count_since(supervisor_.scenes_since(observed_))
                            : 0;
  const monitoring::SupervisorActions actions = supervisor_.process(observed_, scenes);
  perform(actions, now);
  if (actions.changed()) return report(now, true);
  const monitoring::DriftVerdict &reported = report_.verdict, &seen = observed_.verdict;
  const bool other_fault = seen.fault != reported.fault || seen.images_of != reported.images_of;
  return other_fault ? report(now, false) : report_if_due(now);
}

void CalibrationGuard::perform(const monitoring::SupervisorActions& actions, Stamp now) {
  if (actions.cancel_reestimation) background_.cancel();
  if (actions.calibration_changed) monitor_.set_calibration(supervisor_.current());
  if (actions.alternative_changed) monitor_.set_alternative(supervisor_.alternative());
  if (actions.start_reestimation) start_reestimation(actions, now);
}

const CalibrationReport* CalibrationGuard::handle(const CalibrationCommand& command, Stamp now) {
  monitoring::SupervisorActions actions;
  switch (command.kind) {
    case CalibrationCommand::Kind::kUse:
      actions = supervisor_.use(command.calibration, now);
      report_.decision = command.decision;
      break;
    case CalibrationCommand::Kind::kRecalibrate:
      actions = supervisor_.request_recalibration(now);
      break;
    case CalibrationCommand::Kind::kFreeze:
      actions = supervisor_.freeze(command.frozen, now);
      break;
  }
  perform(actions, now);
  return report(now, actions.changed());
}

const CalibrationReport* CalibrationGuard::report_if_due(Stamp now) {
  const bool due = !reported_at_ || now - *reported_at_ >= kReportInterval || now < *reported_at_;
  return due ? report(now, false) : nullptr;
}

const CalibrationReport* CalibrationGuard::report_at_end(Stamp now) {
  return reported_at_ && evaluations_ == report_.evaluations ? nullptr : report(now, false);
}

const CalibrationReport* CalibrationGuard::report(Stamp now, bool changed) {
  if (changed || !reported_at_) report_.since = now;
  reported_at_ = now;
  fill_report(now);
  return &report_;
}

void CalibrationGuard::search_drift(Stamp now) {
  if (!monitor_.search_due() || search_.busy()) return;
  monitor_.begin_search();
  search_.start(now, from_seconds(kSearchDelay),
                [this](const std::stop_token& stop) { monitor_.run_search(stop); });
}

void CalibrationGuard::start_reestimation(const monitoring::SupervisorActions& actions, Stamp now) {
  scenes_ = monitor_.scenes().lend(actions.scenes_since);
  background_.start(now, from_seconds(settings_.supervisor.result_delay),
                    [this, present = supervisor_.current()](std::stop_token stop) {
                      const std::lock_guard one_at_a_time(turn());
                      result_ = monitoring::reestimate(scenes_, intrinsics_, present,
                                                       settings_.reestimate, stop);
                    });
}

void CalibrationGuard::fill_report(Stamp now) {
  report_.stamp = now;
  report_.state = supervisor_.state();
  report_.frozen = supervisor_.frozen();
  report_.recalibration_requested = supervisor_.recalibration_requested();
  report_.T_camera_lidar = supervisor_.current();
  report_.evaluations = evaluations_;
  report_.scenes = monitor_.scenes().size();
  report_.needed_scenes = supervisor_.needed_scenes();
  report_.verdict = observed_.verdict;
  report_.dependence = dependence_;
  report_.estimate = estimate_of(last_result_);
  report_.proposal = estimate_of(supervisor_.proposal());
  report_.history.clear();
  for (const monitoring::HistoryEntry& entry : supervisor_.history()) {
    report_.history.push_back({entry.stamp, entry.state, entry.what, entry.T_camera_lidar});
  }
}

}  // namespace infuse::daemon
