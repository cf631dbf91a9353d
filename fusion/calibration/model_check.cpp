#include "fusion/calibration/model_check.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kMinScenesOfModel = 10;    // effective number of scenes
constexpr double kSignificantSigmas = 3.5;  // standard deviations
constexpr double kSeriousSigmas = 7;

/// Intrinsic parameter of a camera.
struct Intrinsic {
  const char* name;
  const char* unit;
  double display_scale;  // displayed units per unit of the derivative
  double step;           // of the numeric differences
  double tolerance;      // error that a good calibration of the camera leaves, in `unit`
};

constexpr Intrinsic kIntrinsics[] = {{"focal length", "%", 100, 2e-3, 0.3},
                                     {"principal point cx", "px", 1, 1, 3},
                                     {"principal point cy", "px", 1, 1, 3},
                                     {"radial distortion k1", "", 1, 4e-3, 0.01}};
constexpr double kTimeTolerance = 5;  // ms

CameraIntrinsics with_offset(CameraIntrinsics camera, size_t which, double step) {
  switch (which) {
    case 0:
      camera.fx *= std::exp(step);
      camera.fy *= std::exp(step);
      break;
    case 1:
      camera.cx += step;
      break;
    case 2:
      camera.cy += step;
      break;
    default:
      camera.distortion[0] += step;
  }
  return camera;
}

/// Derivatives by a further parameter: one entry per scene, and minus the second derivatives.
struct ParameterScore {
  std::vector<double> scene_scores;
  Vector6 pose_coupling = Vector6::Zero();
  double curvature = 0;
};

/// Value, standard deviation and significance.
ModelMismatch test_score(const ParameterScore& further,
                         const std::vector<SceneGradient>& scene_gradients, double effective_scenes,
                         const Matrix6& inverse) {
  const Vector6 weight = inverse * further.pose_coupling;
  std::vector<double> scores;
  double sum = 0;
  for (size_t s = 0; s < scene_gradients.size(); ++s) {
    if (scene_gradients[s].head<6>() == Vector6::Zero()) continue;
    scores.push_back(further.scene_scores[s] - weight.dot(scene_gradients[s].head<6>()));
    sum += scores.back();
  }
  const auto n = static_cast<double>(scores.size());
  double squares = 0;
  for (const double score : scores) squares += (score - sum / n) * (score - sum / n);
  // Scenes that are alike have like scores.
  const double sigma = std::sqrt(n / effective_scenes * n / (n - 7) * squares);
  const double remaining_curvature = further.curvature - further.pose_coupling.dot(weight);
  ModelMismatch mismatch;
  mismatch.pose_sensitivity = -weight;
  if (!(sigma > 0)) return mismatch;
  mismatch.significance = sum / sigma;
  if (remaining_curvature > 0) {
    mismatch.value = sum / remaining_curvature;
    mismatch.sigma = sigma / remaining_curvature;
  }
  return mismatch;
}

ParameterScore score_intrinsic(Objective& objective, const Eigen::Isometry3d& T,
                               std::span<const RigCamera> cameras, std::span<const Scene> scenes,
                               size_t camera, size_t which,
                               const std::vector<SceneGradient>& scene_gradients) {
  const auto row = static_cast<Eigen::Index>(6 + which);
  const double step = kIntrinsics[which].step;
  ParameterScore out;
  for (size_t s = 0; s < scene_gradients.size(); ++s) {
    out.scene_scores.push_back(scenes[s].camera == camera ? scene_gradients[s](row) : 0.0);
  }
  for (const double side : {-1.0, 1.0}) {
    std::vector<RigCamera> other(cameras.begin(), cameras.end());
    other[camera].model =
        geometry::CameraModel(with_offset(cameras[camera].model.intrinsics(), which, side * step));
    objective.set_cameras(other);
    const std::vector<SceneGradient> there = objective.scene_gradients(T);
    for (size_t s = 0; s < there.size(); ++s) {
      out.pose_coupling -= side / (2 * step) * there[s].head<6>();
      if (scenes[s].camera == camera) out.curvature -= side / (2 * step) * there[s](row);
    }
  }
  objective.set_cameras(cameras);
  return out;
}

/// An image taken dt later sees p from exp(ξ dt) further on: T exp(−ξ dt) p.
ParameterScore score_delay(const Eigen::Isometry3d& T, std::span<const Scene> scenes,
                           const Uncertainty& uncertainty) {
  const Matrix6 adjoint = geometry::adjoint(T);
  ParameterScore out;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const Vector6 moves = -adjoint * *scenes[s].twist;
    out.scene_scores.push_back(moves.dot(uncertainty.scene_gradients[s].head<6>()));
    const Matrix6 H = uncertainty.scene_curvature[s].topRows<6>();
    out.pose_coupling += 0.5 * (H + H.transpose()) * moves;
    out.curvature += moves.dot(H * moves);
  }
  return out;
}

}  // namespace

std::optional<std::string> KnownParameters::invalid() const {
  if (!(focal_sigma >= 0 && focal_sigma <= 0.1)) return "focal_sigma must lie in 0 … 0.1";
  if (!(principal_point_sigma >= 0 && principal_point_sigma <= 100)) {
    return "principal_point_sigma must lie in 0 … 100 px";
  }
  if (!(radial_sigma >= 0 && radial_sigma <= 1)) return "radial_sigma must lie in 0 … 1";
  if (time_sigma < Duration{0} || time_sigma > Duration{100'000'000}) {
    return "time_sigma must lie in 0 … 100 ms";
  }
  return std::nullopt;
}

ModelMismatch make_intrinsic_mismatch(size_t score_intrinsic, double off, size_t camera,
                                      size_t cameras) {
  const Intrinsic& of = kIntrinsics[score_intrinsic];
  return {.parameter =
              std::string(of.name) + (cameras > 1 ? " of camera " + std::to_string(camera) : ""),
          .unit = of.unit,
          .value = of.display_scale * off};
}

std::vector<ModelMismatch> check_model(Objective& objective,
                                       const Eigen::Isometry3d& T_refcam_lidar,
                                       std::span<const RigCamera> cameras,
                                       std::span<const Scene> scenes,
                                       const Uncertainty& uncertainty,
                                       const KnownParameters& known) {
  const std::vector<SceneGradient>& scene_gradients = uncertainty.scene_gradients;
  std::vector<ModelMismatch> mismatches;
  if (!uncertainty.usable()) return mismatches;
  const bool enough = uncertainty.effective_scenes >= kMinScenesOfModel;
  const double known_sigmas[] = {known.focal_sigma, known.principal_point_sigma,
                                 known.principal_point_sigma, known.radial_sigma};
  const Matrix6 inverse = uncertainty.curvature.inverse();
  const auto add = [&](const ParameterScore& further, const ModelMismatch& about,
                       double display_scale, double tolerance, double known_sigma) {
    ModelMismatch mismatch =
        test_score(further, scene_gradients, uncertainty.effective_scenes, inverse);
    if (!enough) mismatch = {.pose_sensitivity = mismatch.pose_sensitivity};
    mismatch.parameter = about.parameter;
    mismatch.unit = about.unit;
    mismatch.value *= display_scale;
    mismatch.sigma *= display_scale;
    mismatch.pose_sensitivity /= display_scale;
    mismatch.known_sigma = display_scale * known_sigma;
    const bool exceeds_tolerance = mismatch.value == 0 || std::abs(mismatch.value) > tolerance;
    mismatch.significant =
        exceeds_tolerance && std::abs(mismatch.significance) > kSignificantSigmas;
    mismatch.serious = exceeds_tolerance && std::abs(mismatch.significance) > kSeriousSigmas;
    mismatches.push_back(mismatch);
  };
  for (size_t c = 0; c < cameras.size(); ++c) {
    for (size_t which = 0; which < std::size(kIntrinsics); ++which) {
      const Intrinsic& of = kIntrinsics[which];
      add(score_intrinsic(objective, T_refcam_lidar, cameras, scenes, c, which, scene_gradients),
          make_intrinsic_mismatch(which, 0, c, cameras.size()), of.display_scale, of.tolerance,
          known_sigmas[which]);
    }
  }
  const bool moving = std::all_of(scenes.begin(), scenes.end(),
                                  [](const Scene& scene) { return scene.twist.has_value(); });
  if (moving) {
    add(score_delay(T_refcam_lidar, scenes, uncertainty),
        {.parameter = "image time offset", .unit = "ms"}, 1e3, kTimeTolerance,
        to_seconds(known.time_sigma));
  }
  return mismatches;
}

Matrix6 model_covariance(std::span<const ModelMismatch> parameters, const Matrix6& scenes) {
  Matrix6 sum = Matrix6::Zero();
  double squares = 0;
  for (const ModelMismatch& one : parameters) {
    const Vector6 moved = one.known_sigma * one.pose_sensitivity;
    sum += moved * moved.transpose();
    squares += one.significance * one.significance;
  }
  const auto tests = static_cast<double>(parameters.size());
  return squares > tests ? sum + (squares / tests - 1) * scenes : sum;
}

}  // namespace infuse::calibration
