#include "fusion/monitoring/calibration_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/monitoring/reduced_image.hpp"

namespace infuse::monitoring {
namespace {

using geometry::Vector6;

constexpr double kMaxGap = 2;                 // s; the motion during a longer gap is unknown
constexpr double kNegligibleEvidence = 0.5;   // nats
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
  if (!(rotation_step > 0) || !(wide_rotation_step > rotation_step) || !(translation_step > 0) ||
      !(time_step > 0) || !(wide_time_step > time_step)) {
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
  last_without_evidence_ = last_stamp_.value_or(Stamp::earliest());
}

void CalibrationMonitor::set_alternative(const std::optional<Eigen::Isometry3d>& T_camera_lidar) {
  alternative_ = T_camera_lidar;
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
  if (axis >= Axis::kWideRotationX) return options_.wide_rotation_step;
  return axis < Axis::kTranslationX ? options_.rotation_step : options_.translation_step;
}

AxisEvaluation CalibrationMonitor::evaluate_axes(const Motion& motion, MonitorReport& report) {
  const double centre = dependence_.evaluate(T_camera_lidar_, image_, points_, camera_);
  report.dependence = centre;
  if (alternative_) {
    report.gain = centre - dependence_.evaluate(*alternative_, image_, points_, camera_);
    report.has_gain = true;
  }
  AxisEvaluation evaluation;
  double lowest = centre;
  double highest = centre;
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
      return dependence_.evaluate(geometry::exp(distance * direction) * T_camera_lidar_, image_,
                                  points_, camera_);
    };
    const double above = evaluate_at(step);
    const double below = evaluate_at(-step);
    fit_parabola(evaluation, k, below, centre, above, step);
    lowest = std::min({lowest, above, below});
    highest = std::max({highest, above, below});
  }
  if (highest - lowest < options_.min_peak) {
    report.reason = "no information in this scene";
    evaluation = {};
  }
  report.evaluated = *report.reason == '\0';
  return evaluation;
}

void CalibrationMonitor::fill_report(MonitorReport& report) {
  report.verdict = detector_.verdict();
  report.verdict.delay_ambiguous_axis = ambiguity_.axis();
  report.verdict.set_fault(camera_check_.fault());
  if (report.verdict.evidence < kNegligibleEvidence) last_without_evidence_ = report.stamp;
  report.since = report.verdict.drifting() ? last_without_evidence_ : Stamp::earliest();
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
      const AxisEvaluation evaluation = evaluate_axes(motion, report);
      last_evaluation_ = grey.stamp;
      travelled_at_evaluation_ = travelled_;
      turned_at_evaluation_ = turned_;
      if (report.evaluated) {
        detector_.add(evaluation);
        ambiguity_.add(motion);
        const double peak =
            evaluation.information(1) * options_.rotation_step * options_.rotation_step;
        report.stored =
            scene_store_.offer(grey, sweep, points_, peak / (peak + kHalfInformationPeak),
                               travelled_, motion.angular_rate.norm());
      }
    }
  }
  fill_report(report);
  // Scenes from before the drift score higher under the present calibration and would keep later
  // ones out of the store.
  if (report.verdict.drift == Drift::kConfirmed) scene_store_.remove_before(report.since);
  return report;
}

}  // namespace infuse::monitoring
