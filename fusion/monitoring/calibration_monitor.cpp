#include "fusion/monitoring/calibration_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/monitoring/reduced_image.hpp"

namespace infuse::monitoring {
namespace {

using geometry::Vector6;

constexpr double kMaxGap = 2;                // s; the motion during a longer gap is unknown
constexpr double kNegligibleEvidence = 0.5;  // nats
constexpr double kSearchEvidence = 2;  // nats, odds of 7 : 1; a suspicion comes later (decision 17)
constexpr int kEvaluationsPerSearch = 3;      // until following scenes support a pose (decision 17)
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
      search_(options.weights),
      camera_check_(options.camera_check),
      scene_store_(options.scene_store) {
  features::find_ring_directions(camera_, T_camera_lidar, step_, rings_);
}

void CalibrationMonitor::set_calibration(const Eigen::Isometry3d& T_camera_lidar) {
  T_camera_lidar_ = T_camera_lidar;
  if (assignment_ != nullptr) assignment_->set_place(camera_of_rig_, T_camera_lidar);
  features::find_ring_directions(camera_, T_camera_lidar, step_, rings_);
  detector_.restart();
  led_.reset();
  job_.outdated = true;
  search_due_ = false;
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
  around.centre =
      dependence_.evaluate(T_camera_lidar, image_.compared().fine, points_.compared(), camera_);
  const double coarse_centre =
      dependence_.evaluate(T_camera_lidar, image_.compared().coarse, points_.compared(), camera_);
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
      return dependence_.evaluate(geometry::exp(distance * direction) * T_camera_lidar,
                                  is_far(axis) ? image_.compared().coarse : image_.compared().fine,
                                  points_.compared(), camera_);
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

/// Compares the pose of the last search with the calibration, in a scene that was not searched.
void CalibrationMonitor::compare_led() {
  if (!led_) return;
  ++led_->evaluations;
  if (!led_->matters) return;
  const auto value = [&](const Eigen::Isometry3d& T) {
    return dependence_.evaluate(T, image_.compared().fine, points_.compared(), camera_);
  };
  const double gain = value(led_->T_camera_lidar) - value(led_->T_tolerated);
  const double most = options_.detector.max_evidence_per_evaluation;
  const double ratio = std::clamp(gain / detector_.noise(), -most, most);
  led_->evidence = std::max(0.0, led_->evidence + ratio);
  led_->support += ratio;
}

/// Compares the camera's place, or where a search leads if that explains more, with others' places.
void CalibrationMonitor::compare_places(const SweepView& sweep, double centre) {
  if (assignment_ == nullptr || !detector_.warmed_up()) return;
  const ComparedPlanes& planes = image_.compared().fine;
  const double led =
      led_ ? dependence_.evaluate(led_->T_camera_lidar, planes, points_.compared(), camera_)
           : centre;
  assignment_->add(camera_of_rig_, planes, sweep, std::max(centre, led), points_,
                   detector_.noise());
}

/// Adds the scene to those that are searched, and decides whether it is time for a search.
void CalibrationMonitor::update_search(const Motion& motion) {
  search_due_ = false;
  if (!searching_) search_.add(image_.compared().fine, points_.compared(), motion);
  const double evidence = detector_.evidence(detector_.strongest_axis());
  if (!detector_.warmed_up() || std::max(evidence, led_evidence()) < kSearchEvidence) {
    return led_.reset();
  }
  if (searching_ || detector_.evaluations_since_onset() < kEvaluationsPerSearch) return;
  const bool stands = led_ && led_->support > 0;
  const int needed = stands ? static_cast<int>(DriftSearch::kScenes) : kEvaluationsPerSearch;
  search_due_ = !led_ || led_->evaluations >= needed;
  if (!search_due_ || options_.background_search) return;
  begin_search();
  run_search();
  finish_search();
}

void CalibrationMonitor::begin_search() {
  search_due_ = false;
  searching_ = true;
  job_ = {.T_camera_lidar = T_camera_lidar_,
          .scenes = static_cast<size_t>(detector_.evaluations_since_onset()),
          .noise = detector_.noise()};
  if (led_ && led_->support > 0) job_.known = led_->estimate.moved;
}

void CalibrationMonitor::run_search(const std::stop_token& stop) {
  job_.found =
      search_.find(job_.T_camera_lidar, job_.known, job_.scenes, job_.noise, camera_, stop);
}

void CalibrationMonitor::finish_search() {
  searching_ = false;
  const double evidence = std::max(detector_.evidence(detector_.strongest_axis()), led_evidence());
  if (job_.outdated || evidence < kSearchEvidence) return;
  Led led{.estimate = job_.found};
  if (led_ && job_.known) led.support = led_->support;
  const Vector6& moved = led.estimate.moved;
  double drifts = 0, tolerated = 0;
  for (size_t k = 0; k < 6; ++k) {
    const double size = std::abs(moved(static_cast<Eigen::Index>(k)));
    drifts = std::max(drifts, size / options_.detector.drift_offset[k]);
    tolerated = std::max(tolerated, size / options_.detector.tolerated_offset[k]);
  }
  led.matters = drifts >= 1;
  led.T_camera_lidar = geometry::exp(moved) * T_camera_lidar_;
  led.T_tolerated = geometry::exp(moved / std::max(tolerated, 1.0)) * T_camera_lidar_;
  led.evidence = evidence;
  led_ = led;
}

/// What the search says of the drift.
void CalibrationMonitor::state_drift(DriftVerdict& verdict) const {
  if (!verdict.drifting() && led_evidence() < options_.detector.suspicion_threshold) return;
  if (!led_) {
    // The parabolas' offsets, which are cut off at their steps.
    for (int k = 0; k < 6; ++k) {
      verdict.sigma(k) = std::hypot(verdict.sigma(k), step_for(static_cast<Axis>(k)));
    }
    return;
  }
  const DriftEstimate& estimate = led_->estimate;
  verdict.evidence = std::max(verdict.evidence, led_evidence());
  verdict.drift = verdict.evidence >= verdict.threshold ? Drift::kConfirmed : Drift::kSuspected;
  verdict.offset = -estimate.moved;
  verdict.at_least = estimate.at_least;
  verdict.delay = estimate.delay;
  for (int k = 0; k < 6; ++k) {
    // What the measure's own bias may be.
    const double bias = options_.detector.tolerated_offset[static_cast<size_t>(k)];
    verdict.sigma(k) = std::hypot(std::sqrt(estimate.covariance(k, k)), bias);
    // No following scene has agreed yet.
    if (!(led_->support > 0)) verdict.sigma(k) = std::hypot(verdict.sigma(k), verdict.offset(k));
  }
  verdict.axis = estimate.likeliest();
  const double most = estimate.gain[static_cast<size_t>(verdict.axis)];
  double second = -1e9;
  for (size_t k = 0; k < kSingleAxes; ++k) {
    const auto axis = static_cast<Axis>(k);
    if (axis == verdict.axis || estimate.gain[k] <= second) continue;
    second = estimate.gain[k];
    verdict.runner_up = axis;
  }
  verdict.runner_up_evidence = std::max(0.0, verdict.evidence - (most - second));
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
  compare_led();
  compare_places(sweep, around.centre);
  update_search(motion);
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
  report.verdict.set_fault(camera_check_.fault(), assignment_ != nullptr
                                                      ? assignment_->images_of(camera_of_rig_)
                                                      : std::string());
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
