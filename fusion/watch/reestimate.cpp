#include "fusion/watch/reestimate.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/named_measures.hpp"

namespace infuse::watch {
namespace {

using calibration::kCancelled;
using calibration::LidarFeature;

/// What no number of scenes of one drive takes away: the measure's own bias there. Told in the
/// covariance.
constexpr double kLastingRotation = 0.3e-3;    // rad
constexpr double kLastingTranslation = 0.003;  // m

/// What halves of the scenes may differ by because they show different things.
constexpr double kBiasRotation = 1e-3;     // rad
constexpr double kBiasTranslation = 0.01;  // m

calibration::Scene to_scene(const StoredScene& stored, const calibration::SceneOptions& options) {
  calibration::Scene scene{.x = stored.x, .y = stored.y, .z = stored.z};
  scene.lidar[calibration::index(LidarFeature::kRelativeReflectivity)] = stored.reflectivity;
  scene.lidar[calibration::index(LidarFeature::kRelativeDiscontinuity)] =
      calibration::relative_discontinuity(stored.ring, stored.discontinuity);
  scene.image = calibration::picture_features(stored.grey, options);
  return scene;
}

calibration::CalibrateOptions settings(const ReestimateOptions& options, std::stop_token stop) {
  calibration::CalibrateOptions out;
  // Edges in full to the end: on real drives the default measure's third of them left one fault in
  // nine unusable.
  out.terms = calibration::named_measures().front().leading;
  out.coarse_points = options.points / 3;
  out.coarse = {
      {.sigma = 4, .tolerance = 1e-2, .anchor = 0.3, .survivors = std::max(options.starts, 2) / 2},
      {.sigma = 2, .tolerance = 5e-3, .anchor = 0.05}};
  out.fine_points = std::numeric_limits<size_t>::max();  // stored scenes are thin already
  out.fine = {{.sigma = 2, .points = options.points},
              {.sigma = 1, .points = options.points, .passes = 2}};
  out.screen.half_width = options.start_rotation;
  out.screen.kept = options.starts - 1;
  out.restarts = options.starts;
  out.start_translation = options.start_translation;
  // Of a calibration that goes on being watched less is asked of every scene by itself.
  out.min_support = 0.75;
  out.check_intrinsics = false;  // a camera that was knocked still has its lens
  out.seed = options.seed;
  out.maximize.stop = std::move(stop);
  return out;
}

/// How well the result is known. The sandwich's spread of some 30 scenes' pulls has 21 numbers and
/// is inverted: too noisy, and 2 to 4 times too sure along whatever direction they happen to agree
/// in. So it meets half-way c H⁻¹, which has the curvature's shape and only its scale from the
/// pulls: c the mean of H times the sandwich (quasi-likelihood's dispersion; Wedderburn 1974).
geometry::Matrix6 covariance_of(const calibration::Uncertainty& uncertainty, size_t scenes) {
  const auto n = static_cast<double>(scenes);
  const double scale = (uncertainty.curvature * uncertainty.covariance).trace() / 6 *
                       std::max(n - 6, 1.0) / std::max(n - 1, 1.0);
  geometry::Vector6 lasting;
  lasting << Eigen::Vector3d::Constant(kLastingRotation),
      Eigen::Vector3d::Constant(kLastingTranslation);
  return 0.5 * uncertainty.covariance + 0.5 * scale * uncertainty.curvature.inverse() +
         geometry::Matrix6(lasting.cwiseAbs2().asDiagonal());
}

double mahalanobis(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                   const geometry::Matrix6& covariance) {
  const geometry::Vector6 apart = geometry::log(a * b.inverse());
  return std::sqrt(std::max(0.0, apart.dot(covariance.inverse() * apart)));
}

/// The same from every second scene, from where the whole ended.
Eigen::Isometry3d half(const std::vector<calibration::Scene>& scenes, size_t first,
                       std::span<const calibration::RigCamera> cameras,
                       const Eigen::Isometry3d& start, const ReestimateOptions& options,
                       const std::stop_token& stop) {
  std::vector<calibration::Scene> own;
  for (size_t i = first; i < scenes.size(); i += 2) own.push_back(scenes[i]);
  calibration::CalibrateOptions only_fine = settings(options, stop);
  only_fine.coarse.clear();
  only_fine.screen.kept = 0;
  only_fine.restarts = 0;
  only_fine.fine = {{.sigma = 2, .points = options.points / 2}};
  return calibration::calibrate(own, cameras, start, only_fine).T_head_lidar;
}

}  // namespace

std::optional<std::string> ReestimateOptions::invalid() const {
  if (starts < 1) return "starts must be at least 1";
  if (!(start_rotation >= 0)) return "start_rotation must not be negative";
  if (!(start_translation > 0)) return "start_translation must be positive";
  if (points < 1000) return "points must be at least 1000";
  if (!(max_split > 0)) return "max_split must be positive";
  return std::nullopt;
}

Reestimate reestimate(std::span<const StoredScene> scenes, const CameraIntrinsics& camera,
                      const Eigen::Isometry3d& present, const ReestimateOptions& options,
                      std::stop_token stop) {
  Reestimate out{.T_camera_lidar = present};
  out.scenes = scenes.size();
  std::vector<calibration::Scene> own;
  const std::vector<calibration::RigCamera> cameras = {{geometry::CameraModel(camera)}};
  const calibration::SceneOptions scene_options{
      .rings = calibration::ring_directions(cameras.front().model, present)};
  for (const StoredScene& scene : scenes) {
    if (!stop.stop_requested()) own.push_back(to_scene(scene, scene_options));
  }
  const calibration::CalibrationResult result =
      calibration::calibrate(own, cameras, present, settings(options, stop));
  out.reason = stop.stop_requested() ? kCancelled : result.reason;
  out.support = result.support;
  if (!out.usable()) return out;
  out.T_camera_lidar = result.T_head_lidar;
  out.covariance = covariance_of(result.uncertainty, scenes.size());
  out.moved = mahalanobis(out.T_camera_lidar, present, out.covariance);
  if (scenes.size() >= 8) {
    // Each half has twice the variance, their difference four times that of the whole.
    geometry::Vector6 bias;
    bias << Eigen::Vector3d::Constant(kBiasRotation), Eigen::Vector3d::Constant(kBiasTranslation);
    const geometry::Matrix6 expected =
        4 * out.covariance + geometry::Matrix6(bias.cwiseAbs2().asDiagonal());
    out.split = mahalanobis(half(own, 0, cameras, out.T_camera_lidar, options, stop),
                            half(own, 1, cameras, out.T_camera_lidar, options, stop), expected) /
                std::sqrt(6.0);
    if (out.split > options.max_split)
      out.reason = "the halves of the scenes contradict each other";
  }
  if (stop.stop_requested()) out.reason = kCancelled;
  return out;
}

}  // namespace infuse::watch
