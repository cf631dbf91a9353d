#include "daemon/tools/calibrate/calibration_run.hpp"

#include "daemon/process/process_times.hpp"
#include "fusion/geometry/draw_uniform.hpp"

namespace infuse::daemon {

std::optional<double> refined_delay(const CalibrationRun& run, const ScenePairs& pairs) {
  if (!run.delay || !run.delay->refined) return std::nullopt;
  return to_seconds(pairs.cameras.front().stamp_delay) - run.delay->later;
}

Eigen::Isometry3d perturb(const Eigen::Isometry3d& T, double angle, double length,
                          std::mt19937_64& random) {
  geometry::Vector6 xi;
  for (int k = 0; k < 6; ++k) {
    xi(k) = geometry::draw_uniform(random) * (k < 3 ? angle : length);
  }
  return geometry::exp(xi) * T;
}

calibration::RigCamera rig_camera(const ScenePairs& pairs, size_t camera) {
  return {geometry::CameraModel(pairs.cameras[camera].intrinsics), T_camera_refcam(pairs, camera)};
}

std::vector<calibration::RigCamera> rig_cameras(const ScenePairs& pairs) {
  std::vector<calibration::RigCamera> cameras;
  for (size_t c = 0; c < pairs.cameras.size(); ++c) cameras.push_back(rig_camera(pairs, c));
  return cameras;
}

Result<calibration::Scene> make_scene(const ScenePairs& pairs, const ScenePair& pair,
                                      const calibration::NamedMeasure& measure,
                                      const Eigen::Isometry3d& T_refcam_lidar) {
  const calibration::RigCamera camera = rig_camera(pairs, pair.camera);
  calibration::SceneOptions options;
  options.equalize = measure.equalize_image;
  options.rings = features::ring_directions(camera.model, camera.T_camera_refcam * T_refcam_lidar);
  options.lidar = {};
  options.image = {};
  for (const auto* terms : {&measure.terms, &measure.search_terms}) {
    for (const calibration::TermOptions& term : *terms) {
      for (const auto feature : term.lidar) options.lidar[calibration::index(feature)] = true;
      for (const auto feature : term.image) options.image[calibration::index(feature)] = true;
    }
  }
  auto scene = calibration::make_scene(pair.sweep, pair.frame, options);
  if (!scene) return fail(scene.error().what, pair.name, scene.error().hint);
  scene->name = pair.name;
  scene->camera = pair.camera;
  scene->twist = pair.twist;
  return scene;
}

Result<std::vector<calibration::Scene>> make_scenes(const ScenePairs& pairs,
                                                    const calibration::NamedMeasure& measure,
                                                    const Eigen::Isometry3d& T_refcam_lidar) {
  std::vector<calibration::Scene> scenes;
  for (const ScenePair& pair : pairs.pairs) {
    auto scene = make_scene(pairs, pair, measure, T_refcam_lidar);
    if (!scene) return tl::unexpected(scene.error());
    scenes.push_back(std::move(*scene));
  }
  return scenes;
}

Result<CalibrationRun> run_calibration(const ScenePairs& pairs,
                                       const calibration::NamedMeasure& measure,
                                       const Eigen::Isometry3d& initial_pose,
                                       const calibration::CalibrateOptions& options,
                                       CalibrationKind kind) {
  const double began = process_cpu_s();
  auto scenes = make_scenes(pairs, measure, initial_pose);
  if (!scenes) return tl::unexpected(scenes.error());
  CalibrationRun run =
      run_calibration(pairs, std::move(*scenes), measure, initial_pose, options, kind);
  run.cpu_s = process_cpu_s() - began;
  return run;
}

CalibrationRun run_calibration(const ScenePairs& pairs, std::vector<calibration::Scene> scenes,
                               const calibration::NamedMeasure& measure,
                               const Eigen::Isometry3d& initial_pose,
                               const calibration::CalibrateOptions& options, CalibrationKind kind) {
  const double began = process_cpu_s();
  CalibrationRun run{.measure = measure.name, .initial_pose = initial_pose, .options = options};
  run.options.terms = measure.terms;
  run.options.search_terms = measure.search_terms;
  if (!measure.has_gradient) run.options.maximize.optimizer = calibration::Optimizer::kSimplex;
  run.cameras = rig_cameras(pairs);
  run.scenes = std::move(scenes);
  if (kind == CalibrationKind::kIntrinsics) {
    run.refined =
        calibration::calibrate_with_intrinsics(run.scenes, run.cameras, initial_pose, run.options);
    run.result = run.refined->result;
    for (size_t c = 0; c < run.cameras.size(); ++c) {
      run.cameras[c].model = geometry::CameraModel(run.refined->cameras[c].intrinsics);
    }
  } else if (kind == CalibrationKind::kDelay) {
    run.delay =
        calibration::calibrate_with_delay(run.scenes, run.cameras, initial_pose, run.options);
    run.result = run.delay->result;
    run.scenes = calibration::scenes_exposed_later(run.scenes, run.delay->later);
  } else if (kind == CalibrationKind::kAnyHeading) {
    run.result =
        calibration::calibrate_any_heading(run.scenes, run.cameras, initial_pose, run.options);
  } else {
    run.result = calibration::calibrate(run.scenes, run.cameras, initial_pose, run.options);
  }
  run.motion =
      motion_uncertainty(pairs, run.result.T_refcam_lidar, run.delay && run.delay->refined);
  run.result.model_covariance += run.motion.covariance;
  // Uncompensated motion may also be why a later check failed: its reason precedes theirs.
  if (!run.motion.reason.empty() && run.result.support >= options.min_support) {
    run.result.reason = run.motion.reason;
  }
  if (run.result.usable()) {
    run.result.reason = calibration::describe_imprecision(
        run.result.covariance(), options.max_rotation_sigma, options.max_translation_sigma);
  }
  run.cpu_s = process_cpu_s() - began;
  return run;
}

}  // namespace infuse::daemon
