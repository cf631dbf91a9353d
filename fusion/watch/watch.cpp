#include "fusion/watch/watch.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::watch {
namespace {

using geometry::Vector6;

constexpr double kLongestGap = 2;     // s; what was driven in a longer one is not known
constexpr double kNoEvidence = 0.5;   // nats
constexpr double kTellingPeak = 0.1;  // nats; a picture with such a peak is worth a half

/// The parabola through three values a step apart.
void set_parabola(AxisLook& look, size_t axis, double below, double here, double above,
                  double step) {
  look.slope[axis] = (above - below) / (2 * step);
  look.bend[axis] = (2 * here - above - below) / (step * step);
  look.step[axis] = step;
}

}  // namespace

std::optional<std::string> WatchOptions::invalid() const {
  if (!(rotation_step > 0) || !(far_step > rotation_step) || !(translation_step > 0) ||
      !(time_step > 0) || !(far_time_step > time_step)) {
    return "steps must be positive, the far ones more than the near ones";
  }
  if (!(focal_samples >= 20)) return "focal_samples must be at least 20";
  if (max_points < min_points || min_points < 100) {
    return "100 <= min_points <= max_points must hold";
  }
  if (!(interval >= 0) || !(spacing >= 0) || !(turning > 0)) {
    return "interval, spacing and turning must not be negative";
  }
  if (!(least_peak >= 0)) return "least_peak must not be negative";
  if (auto wrong = test.invalid()) return "test: " + *wrong;
  if (auto wrong = check.invalid()) return "check: " + *wrong;
  if (auto wrong = store.invalid()) return "store: " + *wrong;
  return std::nullopt;
}

Watch::Watch(const CameraIntrinsics& camera, const Eigen::Isometry3d& T_camera_lidar,
             const WatchOptions& options)
    : options_(options),
      camera_(camera),
      step_(std::max(1, static_cast<int>(std::lround(camera.fx / options.focal_samples)))),
      T_camera_lidar_(T_camera_lidar),
      dependence_(options.weights),
      test_(options.test),
      check_(options.check),
      store_(options.store) {}

void Watch::set_calibration(const Eigen::Isometry3d& T_camera_lidar) {
  T_camera_lidar_ = T_camera_lidar;
  test_.restart();
  quiet_ = last_stamp_.value_or(Stamp::earliest());
}

void Watch::set_alternative(const std::optional<Eigen::Isometry3d>& T_camera_lidar) {
  alternative_ = T_camera_lidar;
}

void Watch::travel(Stamp stamp, const Motion& motion) {
  if (last_stamp_) {
    const double seconds = std::clamp(to_seconds(stamp - *last_stamp_), 0.0, kLongestGap);
    travelled_ += seconds * motion.velocity.norm();
    turned_ += seconds * motion.angular_rate.norm();
  }
  last_stamp_ = stamp;
}

/// Why a picture is not put to the test, or an empty text.
const char* Watch::why_not(const CameraFrame& grey, const Motion& motion) {
  const CameraIntrinsics& camera = camera_.intrinsics();
  if (grey.format != PixelFormat::kGrey8 || grey.width != camera.width ||
      grey.height != camera.height ||
      grey.pixels.size() != grey.row_bytes() * static_cast<size_t>(grey.height)) {
    return "the picture is not as the intrinsics say";
  }
  travel(grey.stamp, motion);
  check_.take(grey, travelled_);
  if (check_.fault() != CameraFault::kNone) return "the camera is at fault";
  if (last_look_ && grey.stamp - *last_look_ < from_seconds(options_.interval)) {
    return "soon after the last look";
  }
  if (travelled_ - looked_travelled_ < options_.spacing &&
      turned_ - looked_turned_ < options_.turning) {
    return "the same place as the last look";
  }
  return "";
}

double Watch::step_along(Axis axis) const {
  if (axis == Axis::kTime) return options_.time_step;
  if (axis == Axis::kFarTime) return options_.far_time_step;
  if (axis >= Axis::kFarRotationX) return options_.far_step;
  return axis < Axis::kX ? options_.rotation_step : options_.translation_step;
}

AxisLook Watch::look(const Motion& motion, WatchReport& report) {
  const double here = dependence_.at(T_camera_lidar_, picture_, points_, camera_);
  report.dependence = here;
  if (alternative_) {
    report.gain = here - dependence_.at(*alternative_, picture_, points_, camera_);
    report.has_gain = true;
  }
  AxisLook look;
  double lowest = here;
  double highest = here;
  for (size_t k = 0; k < kAxes; ++k) {
    const auto axis = static_cast<Axis>(k);
    const double step = step_along(axis);
    Vector6 direction = Vector6::Zero();
    if (near_axis(axis) == Axis::kTime) {
      // A camera that is late by τ saw the world from where it was τ ago: its frame is moved by −τ
      // times the twist, and lidar points in it the other way.
      direction << motion.angular_rate, motion.velocity;
    } else {
      direction(static_cast<Eigen::Index>(near_axis(axis))) = 1;
    }
    const auto ask = [&](double far) {
      return dependence_.at(geometry::exp(far * direction) * T_camera_lidar_, picture_, points_,
                            camera_);
    };
    const double above = ask(step);
    const double below = ask(-step);
    set_parabola(look, k, below, here, above, step);
    lowest = std::min({lowest, above, below});
    highest = std::max({highest, above, below});
  }
  if (highest - lowest < options_.least_peak) {
    report.reason = "nothing to be learned here";
    look = {};
  }
  report.looked = *report.reason == '\0';
  return look;
}

void Watch::judge(WatchReport& report) {
  report.evidence = test_.evidence(test_.strongest());
  report.axis = near_axis(test_.strongest());
  if (report.evidence < kNoEvidence) quiet_ = report.stamp;
  report.drift = !test_.warmed_up() ? Drift::kLearning
                 : test_.certain()  ? Drift::kDrifted
                 : test_.suspect()  ? Drift::kSuspect
                                    : Drift::kHolds;
  const bool moved = report.drift == Drift::kSuspect || report.drift == Drift::kDrifted;
  report.since = moved ? quiet_ : Stamp::earliest();
  for (int k = 0; k < 6; ++k) {
    // The top lies at +d: the present calibration is off by −d.
    const Axis look = test_.stronger_look(static_cast<Axis>(k));
    report.offset(k) = -test_.offset(look);
    report.deviation(k) = test_.deviation(look);
  }
  report.delay = test_.offset(test_.stronger_look(Axis::kTime));
  report.delay_alike = ambiguity_.axis();
  report.fault = check_.fault();
  const bool certain = report.drift == Drift::kDrifted || report.drift == Drift::kSuspect;
  if (certain && report.axis == Axis::kTime && report.fault == CameraFault::kNone) {
    report.fault = CameraFault::kLate;
  }
}

WatchReport Watch::take(const CameraFrame& grey, const SweepView& sweep, const Motion& motion) {
  WatchReport report{.stamp = grey.stamp};
  report.reason = why_not(grey, motion);
  if (*report.reason == '\0') {
    picture_.set(grey, step_);
    points_.set(sweep, camera_, T_camera_lidar_, options_.max_points);
    if (points_.size() < options_.min_points) {
      report.reason = "too few returns in view";
    } else {
      const AxisLook said = look(motion, report);
      last_look_ = grey.stamp;
      looked_travelled_ = travelled_;
      looked_turned_ = turned_;
      if (report.looked) {
        test_.add(said);
        ambiguity_.add(motion);
        const double peak = said.information(1) * options_.rotation_step * options_.rotation_step;
        report.kept = store_.offer(grey, sweep, points_, peak / (peak + kTellingPeak), travelled_,
                                   motion.angular_rate.norm());
      }
    }
  }
  judge(report);
  // Scenes of the calibration that was look better than those of the one that is, and would keep
  // their places from them.
  if (report.drift == Drift::kDrifted) store_.forget_before(report.since);
  return report;
}

}  // namespace infuse::watch
