#include "fusion/calibration/refine_intrinsics.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace infuse::calibration {
namespace {

constexpr double kMinScenesOfIntrinsics = 8;  // effective number of scenes
constexpr size_t kRounds = 2;  // estimates, each from the calibration with the one before

/// Largest standard deviation of a refined intrinsic.
struct Limit {
  const char* name;
  const char* unit;
  double scale;  // displayed units per unit
  double sigma;
};
constexpr std::array<Limit, 4> kLimits = {{{"focal length", " %", 100, 0.0025},
                                           {"principal point cx", " px", 1, 1},
                                           {"principal point cy", " px", 1, 1},
                                           {"radial distortion k1", "", 1, 0.005}}};

/// Why a camera's intrinsics cannot be refined, or an empty text. Standard deviations count only
/// where the other cameras are `settled`: their errors add to the scatter of the scenes.
std::string refusal_of(const CalibrationResult& result, size_t camera, bool settled) {
  const std::string of = result.intrinsics.size() > 1 ? " of camera " + std::to_string(camera) : "";
  const std::string begin = "the scenes do not determine the intrinsics" + of + ": ";
  if (result.uncertainty.effective_scenes < kMinScenesOfIntrinsics) {
    return begin + "fewer than 8 independent scenes";
  }
  const auto& estimate = result.intrinsics[camera];
  if (!estimate) return begin + "fewer than 8 scenes have enough points in view";
  if (!estimate->converged) return begin + "their fit does not converge near the given ones";
  for (size_t k = 0; settled && k < kLimits.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const double sigma = std::sqrt(estimate->covariance(row, row));
    const Limit& limit = kLimits[k];
    if (sigma <= limit.sigma) continue;
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(), "the standard deviation of the %s is %.2g%s (%.2g)",
                  limit.name, limit.scale * sigma, limit.unit, limit.scale * limit.sigma);
    return begin + text.data();
  }
  return {};
}

/// The same of all cameras.
std::string refusal(const CalibrationResult& result, bool settled) {
  for (size_t c = 0; c < result.intrinsics.size(); ++c) {
    if (auto reason = refusal_of(result, c, settled); !reason.empty()) return reason;
  }
  return {};
}

CameraIntrinsics corrected(CameraIntrinsics camera, const Eigen::Vector4d& by) {
  camera.fx *= std::exp(by(0));
  camera.fy *= std::exp(by(0));
  camera.cx += by(1);
  camera.cy += by(2);
  camera.distortion[0] += by(3);
  return camera;
}

/// The given cameras with what is refined of them.
std::vector<RigCamera> with_refined(std::span<const RigCamera> given,
                                    std::span<const RefinedIntrinsics> refined) {
  std::vector<RigCamera> cameras(given.begin(), given.end());
  for (size_t c = 0; c < cameras.size(); ++c) {
    cameras[c].model = geometry::CameraModel(refined[c].intrinsics);
  }
  return cameras;
}

/// Covariance of the pose from that of a camera's intrinsics: four of `model_mismatches`.
geometry::Matrix6 pose_covariance(std::span<const ModelMismatch> mismatches,
                                  const Eigen::Matrix4d& intrinsics) {
  Eigen::Matrix<double, 6, 4> by;
  for (Eigen::Index k = 0; k < 4; ++k) {
    const auto which = static_cast<size_t>(k);
    by.col(k) = kLimits[which].scale * mismatches[which].pose_sensitivity;
  }
  return by * intrinsics * by.transpose();
}

}  // namespace

RefinedCalibration calibrate_with_intrinsics(std::span<const Scene> scenes,
                                             std::span<const RigCamera> cameras,
                                             const Eigen::Isometry3d& T_refcam_lidar_initial,
                                             const CalibrateOptions& options) {
  RefinedCalibration out;
  for (const RigCamera& camera : cameras) {
    out.cameras.push_back({.intrinsics = camera.model.intrinsics()});
  }
  // The estimate is what counts, not whether it contradicts what is given.
  CalibrateOptions estimating = options;
  estimating.check_intrinsics = true;
  estimating.known = {.focal_sigma = 0.1, .principal_point_sigma = 100, .radial_sigma = 1};
  estimating.known.time_sigma = options.known.time_sigma;
  estimating.max_rotation_sigma = estimating.max_translation_sigma = 10;
  Eigen::Isometry3d T = T_refcam_lidar_initial;
  std::vector<RefinedIntrinsics> trial = out.cameras;
  for (size_t round = 0; round < kRounds; ++round) {
    const bool settled = cameras.size() == 1 || round + 1 == kRounds;
    out.result = calibrate(scenes, with_refined(cameras, trial), T, estimating);
    if (!out.result.has_pose || options.maximize.stop.stop_requested()) return out;
    T = out.result.T_refcam_lidar;
    if (out.result.reason = refusal(out.result, settled); !out.result.usable()) return out;
    for (size_t c = 0; c < trial.size(); ++c) {
      trial[c].correction += out.result.intrinsics[c]->correction;
      trial[c].covariance = out.result.intrinsics[c]->covariance;
      trial[c].intrinsics = corrected(cameras[c].model.intrinsics(), trial[c].correction);
    }
  }

  CalibrateOptions final_options = options;
  final_options.known = {.focal_sigma = 0, .principal_point_sigma = 0, .radial_sigma = 0};
  final_options.known.time_sigma = options.known.time_sigma;
  final_options.check_intrinsics = false;
  out.cameras = std::move(trial);
  out.refined = true;
  out.result = calibrate(scenes, with_refined(cameras, out.cameras), T, final_options);
  if (!out.result.uncertainty.usable()) return out;
  for (size_t c = 0; c < cameras.size(); ++c) {
    out.result.model_covariance += pose_covariance(
        std::span(out.result.model_mismatches).subspan(4 * c, 4), out.cameras[c].covariance);
  }
  if (out.result.usable()) {
    out.result.reason = describe_imprecision(out.result.covariance(), options.max_rotation_sigma,
                                             options.max_translation_sigma);
  }
  return out;
}

}  // namespace infuse::calibration
