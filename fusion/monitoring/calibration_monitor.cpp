#include "fusion/monitoring/calibration_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/monitoring/reduced_image.hpp"

namespace infuse::monitoring {
namespace {

using geometry::Vector6;

constexpr double kMaxGap = 2;                // s; the motion during a longer gap is unknown
constexpr double kNegligibleEvidence = 0.5;  // nats
constexpr int kEvaluationsPerMove = 3;       // of the pose that follows a drift
constexpr double kSignificantMove = 3;       // standard deviations: of 15 steps one in 25 by chance
constexpr double kWholeStep = 0.7;           // of a step: the maximum may lie beyond it
constexpr double kHalfInformationPeak = 0.1;  // nats; a peak of this height has information ½

/// Fits the parabola through three values one step apart.
void fit_parabola(AxisEvaluation& evaluation, size_t axis, double below, double centre,
                  double above, double step) {
  evaluation.slope[axis] = (above - below) / (2 * step);
  evaluation.curvature[axis] = (2 * centre - above - below) / (step * step);
  evaluation.step[axis] = step;
}

}  // namespace

std::optional<std::string> MonitorOptions::invalid() const {
  if (!(rotation_step > 0) || !(wide_rotation_step > rotation_step) ||
      !(far_rotation_step > wide_rotation_step) || !(farther_rotation_step > far_rotation_step) ||
      !(translation_step > 0) || !(time_step > 0) || !(wide_time_step > time_step)) {
    return "steps must be positive, and wide steps larger than narrow ones";
  }
  if (!(reduced_focal_length >= 20)) return "reduced_focal_length must be at least 20";
  if (max_points < min_points || min_points < 100) {
    return "100 <= min_points <= max_points must hold";
  }
  if (!(min_interval >= 0) || !(min_distance >= 0) || !(min_rotation > 0)) {
    return "min_interval and min_distance must not be negative, min_rotation must be positive";
  }
  if (!(min_peak >= 0)) return "min_peak must not be negative";
  if (auto wrong = detector.invalid()) return "detector: " + *wrong;
  if (auto wrong = camera_check.invalid()) return "camera_check: " + *wrong;
  if (auto wrong = scene_store.invalid()) return "scene_store: " + *wrong;
  return std::nullopt;
}

CalibrationMonitor::CalibrationMonitor(const CameraIntrinsics& camera,
                                       const Eigen::Isometry3d& T_camera_lidar,
                                       const MonitorOptions& options)
    : options_(options),
      camera_(camera),
      step_(reduction_step(camera, options.reduced_focal_length)),
      T_camera_lidar_(T_camera_lidar),
      dependence_(options.weights),
      detector_(options.detector),
      camera_check_(options.camera_check),
      scene_store_(options.scene_store) {
  features::find_ring_directions(camera_, T_camera_lidar, step_, rings_);
}

void CalibrationMonitor::set_calibration(const Eigen::Isometry3d& T_camera_lidar) {
  T_camera_lidar_ = T_camera_lidar;
  features::find_ring_directions(camera_, T_camera_lidar, step_, rings_);
  detector_.restart();
  led_.reset();
  last_without_evidence_ = last_stamp_.value_or(Stamp::earliest());
}

void CalibrationMonitor::set_alternative(const std::optional<Eigen::Isometry3d>& T_camera_lidar) {
  alternative_.reset();
  if (!T_camera_lidar) return;
  alternative_.emplace(Monitored{*T_camera_lidar, detector_, last_stamp_.value_or(Stamp())});
  alternative_->detector.restart();  // keeps the noise
}

void CalibrationMonitor::accumulate_motion(Stamp stamp, const Motion& motion) {
  if (last_stamp_) {
    const double seconds = std::clamp(to_seconds(stamp - *last_stamp_), 0.0, kMaxGap);
    travelled_ += seconds * motion.velocity.norm();
    turned_ += seconds * motion.angular_rate.norm();
  }
  last_stamp_ = stamp;
}

/// Returns why an image is not evaluated, or an empty text.
const char* CalibrationMonitor::reason_to_skip(const CameraFrame& grey, const Motion& motion) {
  if (!matches_intrinsics(grey, camera_.intrinsics())) {
    return "the image does not match the intrinsics";
  }
  accumulate_motion(grey.stamp, motion);
  camera_check_.process(grey, travelled_);
  if (camera_check_.fault() != CameraFault::kNone) return "the camera has a fault";
  if (last_evaluation_ && grey.stamp - *last_evaluation_ < from_seconds(options_.min_interval)) {
    return "too soon after the last evaluation";
  }
  if (travelled_ - travelled_at_evaluation_ < options_.min_distance &&
      turned_ - turned_at_evaluation_ < options_.min_rotation) {
    return "same place as the last evaluation";
  }
  return "";
}

double CalibrationMonitor::step_for(Axis axis) const {
  if (axis == Axis::kTime) return options_.time_step;
  if (axis == Axis::kWideTime) return options_.wide_time_step;
  if (axis >= Axis::kFartherRotationX) return options_.farther_rotation_step;
  if (is_far(axis)) return options_.far_rotation_step;
  if (axis >= Axis::kWideRotationX) return options_.wide_rotation_step;
  return axis < Axis::kTranslationX ? options_.rotation_step : options_.translation_step;
}

CalibrationMonitor::Surroundings CalibrationMonitor::evaluate(
    const Eigen::Isometry3d& T_camera_lidar, const Motion& motion) {
  Surroundings around;
  around.centre = dependence_.evaluate(T_camera_lidar, image_, points_, camera_);
  const double coarse_centre = dependence_.evaluate(T_camera_lidar, image_, points_, camera_, true);
  for (size_t k = 0; k < kAxes; ++k) {
    const auto axis = static_cast<Axis>(k);
    const double step = step_for(axis);
    Vector6 direction = Vector6::Zero();
    if (base_axis(axis) == Axis::kTime) {
      // A camera that is late by τ sees the world from its pose τ ago: its frame moves by −τ times
      // the twist, and lidar points in it the other way.
      direction << motion.angular_rate, motion.velocity;
    } else {
      direction(static_cast<Eigen::Index>(base_axis(axis))) = 1;
    }
    const auto evaluate_at = [&](double distance) {
      return dependence_.evaluate(geometry::exp(distance * direction) * T_camera_lidar, image_,
                                  points_, camera_, is_far(axis));
    };
    const double above = evaluate_at(step);
    const double below = evaluate_at(-step);
    const double centre = is_far(axis) ? coarse_centre : around.centre;
    fit_parabola(around.axes, k, below, centre, above, step);
    around.spread = std::max({around.spread, std::abs(above - centre), std::abs(below - centre),
                              std::abs(above - below)});
  }
  return around;
}

/// Moves a second pose to where the dependence is highest, one axis at a time.
void CalibrationMonitor::follow_drift(const Surroundings& around, const Motion& motion) {
  if (!detector_.suspected()) return led_.reset();
  if (!led_) {
    led_.emplace(Monitored{T_camera_lidar_, detector_, {}});
    led_->detector.restart();
    led_move_.setConstant(options_.wide_rotation_step);  // not known yet
  }
  const bool has_moved = led_->T_camera_lidar.matrix() != T_camera_lidar_.matrix();
  led_->detector.add(has_moved ? evaluate(led_->T_camera_lidar, motion).axes : around.axes);
  if (led_->detector.evaluations_since_restart() < kEvaluationsPerMove) return;
  Axis leading = Axis::kRotationX;
  double most = 0;  // standard deviations
  for (size_t k = 0; k < kAxes; ++k) {
    const auto axis = static_cast<Axis>(k);
    if (base_axis(axis) == Axis::kTime) continue;
    const double sigmas = std::abs(led_->detector.offset(axis)) / led_->detector.sigma(axis);
    if (sigmas > most) {
      most = sigmas;
      leading = axis;
    }
  }
  led_move_.setZero();
  led_far_ = false;
  if (most < kSignificantMove) return;
  const double moved = led_->detector.offset(leading);
  led_move_(static_cast<Eigen::Index>(base_axis(leading))) = moved;
  led_far_ = leading >= Axis::kFartherRotationX && std::abs(moved) > kWholeStep * step_for(leading);
  led_->T_camera_lidar = geometry::exp(led_move_) * led_->T_camera_lidar;
  led_->detector.restart();
}

/// The amount of a drift, from the pose that the dependence leads to. Before it has settled, the
/// last move is part of the uncertainty.
void CalibrationMonitor::state_drift(DriftVerdict& verdict) const {
  if (!led_ || verdict.axis == Axis::kTime) return;
  if (!led_move_.isZero() && led_->T_camera_lidar.matrix() == T_camera_lidar_.matrix()) {
    // Nothing has moved yet: the parabolas' offsets, which may be cut off at their steps.
    for (int k = 0; k < 6; ++k) {
      verdict.sigma(k) = std::hypot(verdict.sigma(k), step_for(static_cast<Axis>(k)));
    }
    return;
  }
  verdict.offset = geometry::log(T_camera_lidar_ * led_->T_camera_lidar.inverse());
  verdict.at_least = led_far_;
  double most = 0;  // drifts that are to be detected
  for (int k = 0; k < 6; ++k) {
    const auto axis = static_cast<Axis>(k);
    const double sigma = led_->detector.sigma(axis);
    verdict.offset(k) -= led_->detector.offset(axis);  // what is left where it has come to
    // What the measure's own bias may be. One axis at a time, a part of a rotation is taken for the
    // translation that looks alike, so that it counts as one sigma.
    const double bias = options_.detector.tolerated_offset[static_cast<size_t>(k)];
    verdict.sigma(k) =
        std::hypot(std::isfinite(sigma) ? sigma : step_for(axis), bias, led_move_(k));
    const double drift =
        std::abs(verdict.offset(k)) / options_.detector.drift_offset[static_cast<size_t>(k)];
    if (drift <= most || !led_move_.isZero()) continue;
    most = drift;
    verdict.axis = axis;
  }
}

/// Evaluates the selected returns.
void CalibrationMonitor::evaluate_calibrations(const CameraFrame& grey, const SweepView& sweep,
                                               const Motion& motion, MonitorReport& report) {
  const Surroundings around = evaluate(T_camera_lidar_, motion);
  report.dependence = around.centre;
  last_evaluation_ = grey.stamp;
  travelled_at_evaluation_ = travelled_;
  turned_at_evaluation_ = turned_;
  if (around.spread < options_.min_peak) {
    report.reason = "no information in this scene";
    return;
  }
  report.evaluated = true;
  detector_.add(around.axes);
  ambiguity_.add(motion);
  follow_drift(around, motion);
  if (alternative_) {
    const Surroundings other = evaluate(alternative_->T_camera_lidar, motion);
    report.gain = around.centre - other.centre;
    report.has_gain = true;
    alternative_->detector.add(other.axes);
  }
  const double peak = around.axes.information(1) * options_.rotation_step * options_.rotation_step;
  report.stored = scene_store_.offer(grey, sweep, points_, peak / (peak + kHalfInformationPeak),
                                     travelled_, motion.angular_rate.norm());
}

void CalibrationMonitor::fill_report(MonitorReport& report) {
  report.verdict = detector_.verdict();
  state_drift(report.verdict);
  report.verdict.delay_ambiguous_axis = ambiguity_.axis();
  report.verdict.set_fault(camera_check_.fault());
  if (report.verdict.evidence < kNegligibleEvidence) last_without_evidence_ = report.stamp;
  report.since = report.verdict.drifting() ? last_without_evidence_ : Stamp::earliest();
  if (!alternative_) return;
  const DriftVerdict other = alternative_->detector.verdict();
  if (other.evidence < kNegligibleEvidence) alternative_->last_without_evidence = report.stamp;
  report.alternative_drifted = other.drift == Drift::kConfirmed;
  report.alternative_since = alternative_->last_without_evidence;
}

MonitorReport CalibrationMonitor::process(const CameraFrame& grey, const SweepView& sweep,
                                          const Motion& motion) {
  MonitorReport report{.stamp = grey.stamp};
  report.reason = reason_to_skip(grey, motion);
  if (*report.reason == '\0') {
    image_.build(grey, step_, rings_);
    points_.select(sweep, camera_, T_camera_lidar_, options_.max_points);
    if (points_.size() < options_.min_points) {
      report.reason = "too few returns in view";
    } else {
      evaluate_calibrations(grey, sweep, motion, report);
    }
  }
  fill_report(report);
  // Scenes from before the drift score higher under the present calibration and would keep later
  // ones out of the store.
  if (report.verdict.drift == Drift::kConfirmed) scene_store_.remove_before(report.since);
  return report;
}

}  // namespace infuse::monitoring
