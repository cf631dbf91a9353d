#include "fusion/calibration/refine_intrinsics.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace infuse::calibration {
namespace {

constexpr int kRounds = 2;  // estimates, each from the calibration with the one before

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

/// Why the intrinsics cannot be refined, or an empty text.
std::string refusal(const CalibrationResult& result) {
  if (result.uncertainty.effective_scenes < kMinScenesOfIntrinsics) {
    return "fewer than 8 independent scenes";
  }
  const auto& estimate = result.intrinsics.front();
  if (!estimate) return "fewer than 8 scenes have enough points in view";
  if (!estimate->converged) return "their fit does not converge near the given ones";
  for (size_t k = 0; k < kLimits.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const double sigma = std::sqrt(estimate->covariance(row, row));
    const Limit& limit = kLimits[k];
    if (sigma <= limit.sigma) continue;
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(),
                  "the standard deviation of the %s is %.2g%s (allowed: %.2g)", limit.name,
                  limit.scale * sigma, limit.unit, limit.scale * limit.sigma);
    return text.data();
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

/// The scenes of one camera, as of a rig that has no other.
std::vector<Scene> scenes_of(std::span<const Scene> scenes, size_t camera) {
  std::vector<Scene> own;
  for (const Scene& scene : scenes) {
    if (scene.camera != camera) continue;
    own.push_back(scene);
    own.back().camera = 0;
  }
  return own;
}

/// Estimates the intrinsics of one camera, from its own scenes and with a pose of its own: the
/// errors of other cameras' intrinsics move a common pose, and with it every estimate. `T` becomes
/// the camera's pose. Returns the calibration that the estimate, or the refusal, is of.
CalibrationResult refine_one(std::span<const Scene> scenes, const RigCamera& camera,
                             const CalibrateOptions& options, Eigen::Isometry3d& T,
                             RefinedIntrinsics& refined) {
  // The estimate is what counts, not whether it contradicts what is given.
  CalibrateOptions estimating = options;
  estimating.check_intrinsics = true;
  estimating.known = {.focal_sigma = 0.1, .principal_point_sigma = 100, .radial_sigma = 1};
  estimating.known.time_sigma = options.known.time_sigma;
  estimating.max_rotation_sigma = estimating.max_translation_sigma = 10;
  CalibrationResult result;
  for (int round = 0; round < kRounds; ++round) {
    const RigCamera trial{.model = geometry::CameraModel(refined.intrinsics)};
    result = calibrate(scenes, std::span(&trial, 1), T, estimating);
    if (!result.has_pose || options.maximize.stop.stop_requested()) return result;
    T = result.T_refcam_lidar;
    if (result.reason = refusal(result); !result.usable()) return result;
    refined.correction += result.intrinsics.front()->correction;
    refined.covariance = result.intrinsics.front()->covariance;
    refined.intrinsics = corrected(camera.model.intrinsics(), refined.correction);
  }
  return result;
}

/// A refusal of several cameras: the calibration of one of them is not that of the rig.
CalibrationResult refused(const Eigen::Isometry3d& T_refcam_lidar, size_t scenes,
                          const std::string& reason) {
  CalibrationResult result;
  result.T_refcam_lidar = T_refcam_lidar;
  result.scenes.resize(scenes);
  result.reason = result.uncertainty.reason = reason;
  return result;
}

/// Covariance of the pose from that of a camera's intrinsics: four of `parameter_checks`.
geometry::Matrix6 pose_covariance(std::span<const ParameterCheck> checks,
                                  const Eigen::Matrix4d& intrinsics) {
  Eigen::Matrix<double, 6, 4> by;
  for (Eigen::Index k = 0; k < 4; ++k) {
    const auto which = static_cast<size_t>(k);
    by.col(k) = kLimits[which].scale * checks[which].pose_sensitivity;
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
  std::vector<RefinedIntrinsics> refined = out.cameras;
  std::vector<RigCamera> with_refined(cameras.begin(), cameras.end());
  Eigen::Isometry3d T = T_refcam_lidar_initial;
  for (size_t c = 0; c < cameras.size(); ++c) {
    const std::vector<Scene> own = scenes_of(scenes, c);
    Eigen::Isometry3d T_camera_lidar = cameras[c].T_camera_refcam * T;
    out.result = refine_one(own, cameras[c], options, T_camera_lidar, refined[c]);
    if (!out.result.usable()) {
      const std::string of = cameras.size() > 1 ? " of camera " + std::to_string(c) : "";
      if (out.result.has_pose) {
        out.result.reason =
            "the scenes do not determine the intrinsics" + of + ": " + out.result.reason;
      }
      if (cameras.size() > 1) {
        out.result = refused(T_refcam_lidar_initial, scenes.size(), out.result.reason);
      }
      return out;
    }
    with_refined[c].model = geometry::CameraModel(refined[c].intrinsics);
    T = cameras[c].T_camera_refcam.inverse() * T_camera_lidar;
  }

  CalibrateOptions final_options = options;
  final_options.known = {.focal_sigma = 0, .principal_point_sigma = 0, .radial_sigma = 0};
  final_options.known.time_sigma = options.known.time_sigma;
  final_options.check_intrinsics = false;
  out.cameras = std::move(refined);
  out.refined = true;
  out.result = calibrate(scenes, with_refined, T, final_options);
  if (!out.result.uncertainty.usable()) return out;
  for (size_t c = 0; c < cameras.size(); ++c) {
    out.result.model_covariance += pose_covariance(
        std::span(out.result.parameter_checks).subspan(4 * c, 4), out.cameras[c].covariance);
  }
  if (out.result.usable()) {
    out.result.reason = describe_imprecision(out.result.covariance(), options.max_rotation_sigma,
                                             options.max_translation_sigma);
  }
  return out;
}

}  // namespace infuse::calibration
