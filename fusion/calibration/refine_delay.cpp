#include "fusion/calibration/refine_delay.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace infuse::calibration {
namespace {

constexpr int kMaxRounds = 6;             // corrections of the delay; bounds time
constexpr double kConvergedSigmas = 0.3;  // of a correction that is chance
constexpr double kSmallestChange = 2e-4;  // s
const std::string kUndetermined = "the scenes do not determine the delay: ";

/// The time offset among the checked parameters, or null.
const ParameterCheck* find_time_offset(const CalibrationResult& result) {
  const auto found =
      std::find_if(result.parameter_checks.begin(), result.parameter_checks.end(),
                   [](const ParameterCheck& one) { return one.unit == std::string("ms"); });
  return found == result.parameter_checks.end() ? nullptr : &*found;
}

/// Why the time offset of a result cannot be used, or an empty text.
std::string refusal(const CalibrationResult& result, double max_sigma) {
  if (!result.has_pose || !result.uncertainty.usable())
    return kUndetermined + "they do not determine a pose";
  const ParameterCheck* offset = find_time_offset(result);
  if (offset == nullptr || offset->sigma <= 0) {
    return kUndetermined + "fewer than 10 independent scenes, or always the same motion";
  }
  if (1e-3 * offset->sigma <= max_sigma) return {};
  std::array<char, 160> text{};
  std::snprintf(
      text.data(), text.size(),
      "its standard deviation is %.1f ms (allowed: %.1f); drive bends, at different speeds",
      offset->sigma, 1e3 * max_sigma);
  return kUndetermined + text.data();
}

/// Options of the calibrations on the way: no checks but that of the time.
CalibrateOptions without_checks(CalibrateOptions options, double max_delay) {
  options.restarts = options.fine_restarts = options.splits = 0;
  options.check_intrinsics = false;
  options.known.time_sigma = from_seconds(std::min(max_delay, 0.1));
  return options;
}

}  // namespace

std::optional<std::string> DelayOptions::invalid() const {
  if (!(max_delay > 0 && max_delay <= 0.5)) return "max_delay must be between 0 and 0.5 s";
  if (!(step > 0 && step <= max_delay)) return "step must be positive and at most max_delay";
  if (!(max_sigma > 0)) return "max_sigma must be positive";
  return std::nullopt;
}

std::vector<Scene> scenes_exposed_later(std::span<const Scene> scenes, double later) {
  std::vector<Scene> out(scenes.begin(), scenes.end());
  for (Scene& scene : out) {
    if (!scene.twist) continue;
    const Eigen::Isometry3f T = geometry::exp(-later * *scene.twist).cast<float>();
    for (size_t i = 0; i < scene.size(); ++i) {
      const Eigen::Vector3f p = T * Eigen::Vector3f(scene.x[i], scene.y[i], scene.z[i]);
      scene.x[i] = p.x();
      scene.y[i] = p.y();
      scene.z[i] = p.z();
    }
  }
  return out;
}

DelayCalibration calibrate_with_delay(std::span<const Scene> scenes,
                                      std::span<const RigCamera> cameras,
                                      const Eigen::Isometry3d& T_refcam_lidar_initial,
                                      const CalibrateOptions& options, const DelayOptions& delays) {
  DelayCalibration out;
  const bool moving = std::all_of(scenes.begin(), scenes.end(),
                                  [](const Scene& scene) { return scene.twist.has_value(); });
  if (!moving) {
    out.result.T_refcam_lidar = T_refcam_lidar_initial;
    out.result.scenes.resize(scenes.size());
    out.result.reason = kUndetermined + "the vehicle's motion is not known at every image";
    return out;
  }
  CalibrateOptions searching = without_checks(options, delays.max_delay);
  const auto calibrate_at = [&](double later, const CalibrateOptions& with,
                                const Eigen::Isometry3d& T) {
    return calibrate(scenes_exposed_later(scenes, later), cameras, T, with);
  };

  // Coarse: the delay with the highest dependence.
  searching.fine = {quick_level(options)};
  double best_value = -1e9;
  Eigen::Isometry3d T = T_refcam_lidar_initial;
  const auto half = static_cast<int>(delays.max_delay / delays.step + 1e-9);
  for (int k = -half; k <= half; ++k) {
    const double later = k * delays.step;
    CalibrationResult tried = calibrate_at(later, searching, T_refcam_lidar_initial);
    if (options.maximize.stop.stop_requested()) return {.result = std::move(tried)};
    if (!tried.has_pose || !(tried.value > best_value)) continue;
    best_value = tried.value;
    out.later = later;
    T = tried.T_refcam_lidar;
  }

  // Fine: until what remains is chance.
  searching.fine = options.fine;
  bool converged = false;
  for (int round = 0; round < kMaxRounds && !converged; ++round) {
    out.result = calibrate_at(out.later, searching, T);
    if (out.result.reason = refusal(out.result, delays.max_sigma); !out.result.usable()) return out;
    T = out.result.T_refcam_lidar;
    const ParameterCheck& offset = *find_time_offset(out.result);
    out.sigma = 1e-3 * offset.sigma;
    const double change = std::clamp(1e-3 * offset.value, -delays.step, delays.step);
    converged = std::abs(change) < std::max(kConvergedSigmas * out.sigma, kSmallestChange);
    if (!converged) out.later += change;
    if (std::abs(out.later) > delays.max_delay) break;
  }
  if (!converged) {
    out.result.reason = kUndetermined + "its estimate does not converge";
    return out;
  }
  CalibrateOptions with_refined = options;
  with_refined.known.time_sigma = from_seconds(std::min(out.sigma, 0.1));
  out.refined = true;
  out.result = calibrate_at(out.later, with_refined, T);
  return out;
}

}  // namespace infuse::calibration
