#include "tests/study/months/simulated_camera.hpp"

#include "daemon/calibration/calibration_guard.hpp"

namespace infuse::study {
namespace {

using monitoring::Axis;
using monitoring::CalibrationState;
using monitoring::CameraFault;

/// What the evaluation of an image is worth: the standard deviation of its offset in rad, m or s,
/// and the step. The noise of the measure is as the sequential test assumes it before it has
/// learned: sigma² = kappa ÷ curvature.
struct AxisModel {
  double sigma, step;
};
constexpr double kKappa = 0.0045;
constexpr AxisModel kRotation{0.004, 8.7e-3}, kTranslation{0.03, 0.06}, kTime{0.03, 0.08},
    kWideRotation{0.012, 0.0214}, kWideTime{0.06, 0.24}, kFarRotation{0.012, 0.0524},
    kFartherRotation{0.024, 0.105};

const AxisModel& model_of(Axis axis) {
  if (axis <= Axis::kRotationZ) return kRotation;
  if (axis <= Axis::kTranslationZ) return kTranslation;
  if (axis == Axis::kTime) return kTime;
  if (axis == Axis::kWideTime) return kWideTime;
  if (axis >= Axis::kFartherRotationX) return kFartherRotation;
  return monitoring::is_far(axis) ? kFarRotation : kWideRotation;
}

constexpr double kNegligible = 0.5;  // nats

CameraFault fault_of(const std::string& camera, const FaultSchedule& faults) {
  if (faults.has(camera, "black")) return CameraFault::kBlack;
  if (faults.has(camera, "frozen")) return CameraFault::kFrozen;
  return faults.has(camera, "dirty") ? CameraFault::kDirty : CameraFault::kNone;
}

}  // namespace

void SimulatedCamera::restart(const Eigen::Isometry3d& T_camera_lidar,
                              const daemon::CalibrationSettings& settings) {
  settings_ = settings;
  detector_.emplace(settings.monitor.detector);
  supervisor_.emplace(T_camera_lidar, settings.supervisor);
  last_without_evidence_ = Stamp::earliest();
  reported_at_.reset();
  last_result_.reset();
  evaluations_ = decision_ = 0;
}

void SimulatedCamera::handle(const daemon::CalibrationCommand& command, Stamp now) {
  using Kind = daemon::CalibrationCommand::Kind;
  monitoring::SupervisorActions actions;
  if (command.kind == Kind::kRecalibrate) actions = supervisor_->request_recalibration(now);
  if (command.kind == Kind::kUse) {
    actions = supervisor_->use(command.calibration, now);
    decision_ = command.decision;
  }
  if (command.kind == Kind::kFreeze) actions = supervisor_->freeze(command.frozen, now);
  if (actions.calibration_changed) restart_evidence(now);
  commanded_ = true;
}

void SimulatedCamera::restart_evidence(Stamp now) {
  detector_->restart();
  last_without_evidence_ = now;
}

void SimulatedCamera::move(const FaultSchedule& faults) {
  for (const Fault& fault : faults.begun()) {
    if (fault.subject != name_) continue;
    geometry::Vector6 moved = geometry::Vector6::Zero();
    if (fault.kind == "turned") moved[1] = fault.value;
    if (fault.kind == "slid") moved[3] = fault.value;
    T_true_ = geometry::exp(moved) * T_true_;
  }
}

/// The maximum of the dependence is where the true pose is.
monitoring::AxisEvaluation SimulatedCamera::evaluate(double late) {
  const geometry::Vector6 offset = geometry::log(T_true_ * supervisor_->current().inverse());
  monitoring::AxisEvaluation evaluation;
  monitoring::PerAxis errors{};
  for (size_t k = 0; k < monitoring::kAxes; ++k) {
    const auto axis = static_cast<Axis>(k);
    const AxisModel& model = model_of(axis);
    const Axis base = monitoring::base_axis(axis);
    const double true_offset = base == Axis::kTime ? late : offset[static_cast<Eigen::Index>(base)];
    // The far steps see the peak that the wide ones see.
    const size_t wide = static_cast<size_t>(Axis::kWideRotationX) + static_cast<size_t>(base);
    const double error = monitoring::is_far(axis) ? errors[wide] * model.sigma / kWideRotation.sigma
                                                  : noise(model.sigma);
    errors[k] = error;
    const double seen = std::clamp(true_offset + error, -1.5 * model.step, 1.5 * model.step);
    evaluation.step[k] = model.step;
    evaluation.curvature[k] = kKappa / (model.sigma * model.sigma);
    evaluation.slope[k] = evaluation.curvature[k] * seen;
  }
  return evaluation;
}

/// As the monitor reports it.
monitoring::MonitorReport SimulatedCamera::report_of(Stamp now, const FaultSchedule& faults) {
  monitoring::MonitorReport report{.stamp = now, .evaluated = true};
  report.verdict = detector_->verdict();
  report.verdict.set_fault(fault_of(name_, faults));
  if (report.verdict.evidence < kNegligible) last_without_evidence_ = now;
  report.since = report.verdict.drifting() ? last_without_evidence_ : Stamp::earliest();
  if (const auto& other = supervisor_->alternative()) {
    const auto misfit = [&](const Eigen::Isometry3d& T) {
      const geometry::Vector6 error = geometry::log(T_true_ * T.inverse());
      return error.head<3>().squaredNorm() / (kRotation.sigma * kRotation.sigma) +
             error.tail<3>().squaredNorm() / (kTranslation.sigma * kTranslation.sigma);
    };
    report.has_gain = true;
    report.gain =
        0.5 * kKappa * (misfit(*other) - misfit(supervisor_->current())) + noise(0.2 * kKappa);
  }
  return report;
}

monitoring::Reestimate SimulatedCamera::reestimate(const FaultSchedule& faults) {
  constexpr double kRotationSigma = 6e-4, kTranslationSigma = 5e-3;
  monitoring::Reestimate result{.T_initial = supervisor_->current()};
  result.scenes = 30;
  if (faults.has(name_, "unclear")) {
    result.reason = "the restarts do not converge";
    return result;
  }
  geometry::Vector6 error;
  for (int k = 0; k < 6; ++k) error[k] = noise(k < 3 ? kRotationSigma : kTranslationSigma);
  if (const Fault* misled = faults.find(name_, "misled")) error[1] += misled->value;
  result.T_camera_lidar = geometry::exp(error) * T_true_;
  result.covariance.diagonal().head<3>().setConstant(kRotationSigma * kRotationSigma);
  result.covariance.diagonal().tail<3>().setConstant(kTranslationSigma * kTranslationSigma);
  const geometry::Vector6 moved =
      geometry::log(result.T_camera_lidar * supervisor_->current().inverse());
  result.moved = std::sqrt(moved.dot(result.covariance.inverse() * moved));
  return result;
}

// As CalibrationGuard does with the monitor's reports.
std::optional<daemon::CalibrationReport> SimulatedCamera::observe(Stamp now, bool observed,
                                                                  const FaultSchedule& faults) {
  move(faults);
  if (!observed) return std::nullopt;
  const Fault* late = faults.find(name_, "late");
  const bool evaluated = fault_of(name_, faults) == CameraFault::kNone;
  if (evaluated) {
    detector_->add(evaluate(late != nullptr ? late->value : 0));
    ++evaluations_;
  }
  monitoring::MonitorReport monitor = report_of(now, faults);
  monitor.evaluated = evaluated;
  const double scene_age = monitor.since == Stamp::earliest()
                               ? 60
                               : to_seconds(now - supervisor_->scenes_since(monitor));
  const auto scenes = static_cast<size_t>(std::clamp(scene_age / 2, 0.0, 60.0));
  const monitoring::SupervisorActions actions = supervisor_->process(monitor, scenes);
  if (actions.calibration_changed) restart_evidence(now);
  if (actions.start_reestimation) {
    last_result_ = reestimate(faults);
    supervisor_->finish_reestimation(*last_result_);
  }
  const bool changed = actions.changed() || std::exchange(commanded_, false);
  if (!changed && reported_at_ && now - *reported_at_ < daemon::CalibrationGuard::kReportInterval) {
    return std::nullopt;
  }
  if (changed || !reported_at_) since_ = now;
  reported_at_ = now;
  return daemon_report(monitor);
}

daemon::CalibrationReport SimulatedCamera::daemon_report(const monitoring::MonitorReport& monitor) {
  daemon::CalibrationReport report;
  report.camera = name_;
  report.stamp = monitor.stamp;
  report.state = supervisor_->state();
  report.since = since_;
  report.policy = settings_.supervisor.policy;
  report.frozen = supervisor_->frozen();
  report.decision = decision_;
  if (const auto& proposal = supervisor_->proposal()) {
    report.proposal = {proposal->T_camera_lidar, proposal->covariance, proposal->moved,
                       proposal->scenes,         proposal->reason,     proposal->T_initial};
  }
  report.T_camera_lidar = supervisor_->current();
  report.evaluations = evaluations_;
  report.verdict = monitor.verdict;
  if (last_result_) {
    report.estimate = {last_result_->T_camera_lidar, last_result_->covariance,
                       last_result_->moved,          last_result_->scenes,
                       last_result_->reason,         last_result_->T_initial};
  }
  for (const monitoring::HistoryEntry& entry : supervisor_->history()) {
    report.history.push_back({entry.stamp, entry.state, entry.what, entry.T_camera_lidar});
  }
  return report;
}

}  // namespace infuse::study
