#include "fusion/monitoring/reestimate.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/compact_scene.hpp"
#include "fusion/calibration/named_measures.hpp"

namespace infuse::monitoring {
namespace {

using calibration::kCancelled;
using calibration::LidarFeature;

/// Difference between halves of the scenes because they show different things.
constexpr double kHalfBiasRotation = 1e-3;     // rad
constexpr double kHalfBiasTranslation = 0.01;  // m

/// Intrinsics of an image that is reduced by means of `step` × `step` pixels.
CameraIntrinsics reduced(CameraIntrinsics camera, int step) {
  camera.width /= step;
  camera.height /= step;
  camera.fx /= step;
  camera.fy /= step;
  camera.cx = (camera.cx + 0.5) / step - 0.5;
  camera.cy = (camera.cy + 0.5) / step - 0.5;
  return camera;
}

calibration::Scene to_scene(const StoredScene& stored, const calibration::SceneOptions& options) {
  calibration::Scene scene{.x = stored.x, .y = stored.y, .z = stored.z};
  scene.lidar[calibration::index(LidarFeature::kRelativeReflectivity)] = stored.reflectivity;
  scene.lidar[calibration::index(LidarFeature::kRelativeDiscontinuity)] =
      features::relative_discontinuity(stored.ring, stored.discontinuity);
  scene.image = calibration::compute_image_features(stored.grey, options);
  return scene;
}

calibration::CalibrateOptions calibrate_options(const ReestimateOptions& options,
                                                std::stop_token stop) {
  calibration::CalibrateOptions out;
  // Edges with full weight to the end: on real drives the default measure, with a third of it, left
  // one fault in nine without a usable result.
  out.terms = calibration::named_measures().front().search_terms;
  out.coarse_points = options.points / 3;
  out.coarse = {{.sigma = 4,
                 .tolerance = 1e-2,
                 .prior_weight = 0.3,
                 .survivors = std::max(options.searches, 2) / 2},
                {.sigma = 2, .tolerance = 5e-3, .prior_weight = 0.05}};
  out.fine_points = std::numeric_limits<size_t>::max();  // scenes are thinned when stored
  out.fine = {{.sigma = 2, .points = options.points},
              {.sigma = 1, .points = options.points, .passes = 2}};
  out.screen.half_width = options.screen_half_width;
  out.screen.survivors = options.searches - 1;
  out.restarts = out.restarts_of_few = options.searches;
  out.fine_restarts = 0;  // beside the stream, and measured without
  // A knocked camera is still near where it was.
  out.restart_rotation = 0.02;
  out.restart_translation = 0.08;
  out.initial_translation_sigma = options.initial_translation_sigma;
  // A calibration that is monitored further needs less support by every scene alone.
  out.min_support = 0.75;
  out.check_intrinsics = false;  // a knocked camera still has its lens
  // What is not known of it moves this estimate and the present calibration alike.
  out.known = {.focal_sigma = 0, .principal_point_sigma = 0, .radial_sigma = 0, .time_sigma = {}};
  out.seed = options.seed;
  out.maximize.stop = std::move(stop);
  return out;
}

/// The scenes as a calibration looks them up, one after the other: a scene's features take several
/// times as much memory before.
std::vector<calibration::Scene> prepare(std::span<const StoredScene* const> stored,
                                        const calibration::RigCamera& camera,
                                        const Eigen::Isometry3d& current,
                                        const calibration::CalibrateOptions& options,
                                        const std::stop_token& stop) {
  const calibration::SceneOptions features{.rings =
                                               features::ring_directions(camera.model, current)};
  const calibration::CompactOptions compact{
      .image = calibration::compared_image_features(options.terms),
      .blurs = calibration::image_blurs(options),
      .margin = {}};
  std::vector<calibration::Scene> scenes;
  for (const StoredScene* scene : stored) {
    if (stop.stop_requested()) break;
    scenes.push_back(to_scene(*scene, features));
    calibration::compact_scene(scenes.back(), camera, current, compact);
  }
  return scenes;
}

double mahalanobis(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                   const geometry::Matrix6& covariance) {
  const geometry::Vector6 apart = geometry::log(a * b.inverse());
  return std::sqrt(std::max(0.0, apart.dot(covariance.inverse() * apart)));
}

/// Estimates from every second scene, starting at the result of all scenes.
Eigen::Isometry3d estimate_from_half(const std::vector<calibration::Scene>& scenes, size_t first,
                                     std::span<const calibration::RigCamera> cameras,
                                     const Eigen::Isometry3d& initial_pose,
                                     const ReestimateOptions& options,
                                     const std::stop_token& stop) {
  std::vector<calibration::Scene> own;
  for (size_t i = first; i < scenes.size(); i += 2) own.push_back(scenes[i]);
  calibration::CalibrateOptions only_fine = calibrate_options(options, stop);
  only_fine.coarse.clear();
  only_fine.screen.survivors = 0;
  only_fine.restarts = 0;
  only_fine.fine = {{.sigma = 2, .points = options.points / 2}};
  return calibration::calibrate(own, cameras, initial_pose, only_fine).T_refcam_lidar;
}

}  // namespace

std::optional<std::string> ReestimateOptions::invalid() const {
  if (searches < 1) return "searches must be at least 1";
  if (!(screen_half_width >= 0)) return "screen_half_width must not be negative";
  if (!(initial_translation_sigma > 0)) return "initial_translation_sigma must be positive";
  if (points < 1000) return "points must be at least 1000";
  if (!(max_split_half_distance > 0)) return "max_split_half_distance must be positive";
  return std::nullopt;
}

Reestimate reestimate(std::span<const StoredScene* const> scenes, const CameraIntrinsics& camera,
                      const Eigen::Isometry3d& current, const ReestimateOptions& options,
                      const std::stop_token& stop) {
  Reestimate out{.T_initial = current, .T_camera_lidar = current};
  out.scenes = scenes.size();
  const int step = scenes.empty() ? 1 : scenes.front()->step;
  const std::vector<calibration::RigCamera> cameras = {
      {geometry::CameraModel(reduced(camera, step))}};
  const calibration::CalibrateOptions full = calibrate_options(options, stop);
  const std::vector<calibration::Scene> own = prepare(scenes, cameras.front(), current, full, stop);
  const calibration::CalibrationResult result = calibration::calibrate(own, cameras, current, full);
  out.reason = stop.stop_requested() ? kCancelled : result.reason;
  out.support = result.support;
  if (!out.usable()) return out;
  out.T_camera_lidar = result.T_refcam_lidar;
  // What is not known of the intrinsics moves all estimates with them alike.
  out.covariance = result.uncertainty.covariance;
  out.moved = mahalanobis(out.T_camera_lidar, current, out.covariance);
  if (scenes.size() >= 8) {
    // Each half has twice the variance of the whole, and their difference four times.
    geometry::Vector6 bias;
    bias << Eigen::Vector3d::Constant(kHalfBiasRotation),
        Eigen::Vector3d::Constant(kHalfBiasTranslation);
    const geometry::Matrix6 expected =
        4 * out.covariance + geometry::Matrix6(bias.cwiseAbs2().asDiagonal());
    out.split_half_distance =
        mahalanobis(estimate_from_half(own, 0, cameras, out.T_camera_lidar, options, stop),
                    estimate_from_half(own, 1, cameras, out.T_camera_lidar, options, stop),
                    expected) /
        std::sqrt(6.0);
    if (out.split_half_distance > options.max_split_half_distance)
      out.reason = "the halves of the scenes contradict each other";
  }
  if (stop.stop_requested()) out.reason = kCancelled;
  return out;
}

}  // namespace infuse::monitoring
