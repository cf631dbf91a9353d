#include "fusion/calibration/refine_intrinsics.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace infuse::calibration {
namespace {

constexpr double kMinScenesOfIntrinsics = 8;  // effective number of scenes
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
  const std::string begin = "the scenes do not determine the intrinsics: ";
  if (result.uncertainty.effective_scenes < kMinScenesOfIntrinsics) {
    return begin + "fewer than 8 independent scenes";
  }
  const auto& estimate = result.intrinsics.front();
  if (!estimate) return begin + "fewer than 8 scenes have enough points in view";
  if (!estimate->converged) return begin + "their fit does not converge near the given ones";
  for (size_t k = 0; k < kLimits.size(); ++k) {
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

CameraIntrinsics corrected(CameraIntrinsics camera, const Eigen::Vector4d& by) {
  camera.fx *= std::exp(by(0));
  camera.fy *= std::exp(by(0));
  camera.cx += by(1);
  camera.cy += by(2);
  camera.distortion[0] += by(3);
  return camera;
}

/// Covariance of the pose from that of the intrinsics: the first four of `model_mismatches`.
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

RefinedCalibration calibrate_with_intrinsics(std::span<const Scene> scenes, const RigCamera& camera,
                                             const Eigen::Isometry3d& T_camera_lidar_initial,
                                             const CalibrateOptions& options) {
  const CameraIntrinsics& given = camera.model.intrinsics();
  RefinedCalibration out{.intrinsics = given};
  // The estimate is what counts, not whether it contradicts what is given.
  CalibrateOptions estimating = options;
  estimating.known = {.focal_sigma = 0.1, .principal_point_sigma = 100, .radial_sigma = 1};
  estimating.known.time_sigma = options.known.time_sigma;
  estimating.max_rotation_sigma = estimating.max_translation_sigma = 10;
  Eigen::Isometry3d T = T_camera_lidar_initial;
  for (int round = 0; round < kRounds; ++round) {
    RigCamera trial = camera;
    trial.model = geometry::CameraModel(corrected(given, out.correction));
    out.result = calibrate(scenes, std::span(&trial, 1), T, estimating);
    if (!out.result.has_pose || options.maximize.stop.stop_requested()) return out;
    T = out.result.T_refcam_lidar;
    if (out.result.reason = refusal(out.result); !out.result.usable()) {
      out.correction.setZero();
      return out;
    }
    out.correction += out.result.intrinsics.front()->correction;
    out.covariance = out.result.intrinsics.front()->covariance;
  }

  CalibrateOptions with_refined = options;
  with_refined.known = {.focal_sigma = 0, .principal_point_sigma = 0, .radial_sigma = 0};
  with_refined.known.time_sigma = options.known.time_sigma;
  with_refined.check_intrinsics = false;
  out.intrinsics = corrected(given, out.correction);
  out.refined = true;
  RigCamera refined = camera;
  refined.model = geometry::CameraModel(out.intrinsics);
  out.result = calibrate(scenes, std::span(&refined, 1), T, with_refined);
  if (!out.result.uncertainty.usable()) return out;
  out.result.model_covariance += pose_covariance(out.result.model_mismatches, out.covariance);
  if (out.result.usable()) {
    out.result.reason = describe_imprecision(out.result.covariance(), options.max_rotation_sigma,
                                             options.max_translation_sigma);
  }
  return out;
}

}  // namespace infuse::calibration
