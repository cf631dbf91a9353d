#include "fusion/calibration/calibrate.hpp"

#include <algorithm>

#include "fusion/calibration/calibration_steps.hpp"
#include "fusion/calibration/rejection_reason.hpp"
#include "fusion/calibration/scene_similarity.hpp"

namespace infuse::calibration {
namespace {

constexpr double kRetryPriorScale = 3;  // factor of the levels' prior weights in a second attempt

double mean_support(const std::vector<SceneSupport>& scenes) {
  double sum = 0;
  int seen = 0;
  for (const SceneSupport& scene : scenes) {
    if (scene.points == 0) continue;
    sum += scene.support;
    ++seen;
  }
  return seen == 0 ? 0 : sum / seen;
}

/// The measure at the maximum, with all points of the last level, and how sure its pose is. The
/// points and their objective are released before the intrinsics are estimated with others.
void evaluate_maximum(CalibrationSteps& calibration, const Eigen::Isometry3d& initial_pose,
                      const Level& level, CalibrationResult& result) {
  CoarseToFine& search = calibration.final_search();
  const VisiblePoints points = search.visible_points(result.T_refcam_lidar, level.points);
  Objective objective = search.make_objective(points, level.sigma);
  result.points = points.size();
  result.value = objective.evaluate(result.T_refcam_lidar, false).estimate.value;
  result.initial_value = objective.evaluate(initial_pose, false).estimate.value;
  result.uncertainty =
      estimate_uncertainty(objective, result.T_refcam_lidar, calibration.similarity());
  result.evaluations = objective.evaluations();
}

/// Calibrates with the levels' prior weights multiplied by `prior_scale`, and checks the result.
CalibrationResult run_attempt(CalibrationSteps& calibration, const Eigen::Isometry3d& initial_pose,
                              size_t scenes, const CalibrateOptions& options, double prior_scale) {
  CalibrationResult result;
  CoarseToFine& search = calibration.final_search();
  const CalibrationSteps::RestartResult restart_result =
      calibration.run_restarts(calibration.find_basin(prior_scale));
  const std::span<const Level> fine(options.fine);
  const Maximum fine_maximum =
      calibration.fine_search().ascend(restart_result.T, fine.first(fine.size() - 1));
  Maximum maximum = search.ascend(fine_maximum.T_refcam_lidar, fine.last(1));
  if (const auto higher = calibration.run_fine_restarts(maximum.T_refcam_lidar)) {
    maximum = search.ascend(*higher, fine.last(1));
  }
  if (options.maximize.stop.stop_requested()) {
    result.T_refcam_lidar = initial_pose;
    result.reason = maximum.reason;
    return result;
  }
  result.T_refcam_lidar = maximum.T_refcam_lidar;
  result.has_pose = maximum.usable();
  result.restarts = restart_result.restarts;
  result.converged_restarts = restart_result.converged_restarts;
  result.best_of_restarts = restart_result.best_of_restarts;

  evaluate_maximum(calibration, initial_pose, fine.back(), result);
  result.intrinsics =
      calibration.estimate_all_intrinsics(result.T_refcam_lidar, result.uncertainty);
  result.parameter_checks =
      calibration.check_parameters(result.T_refcam_lidar, result.uncertainty, result.intrinsics);
  result.model_covariance =
      model_covariance(result.parameter_checks, result.uncertainty.covariance);
  result.scenes = scene_support(calibration.fine_search(), result.T_refcam_lidar, scenes,
                                options.support_sigma);
  result.support = mean_support(result.scenes);
  const double moved =
      (result.T_refcam_lidar.inverse().translation() - initial_pose.inverse().translation()).norm();
  result.reason = rejection_reason(result, maximum, moved,
                                   calibration.delay_along_travel(result.T_refcam_lidar), options);
  return result;
}

}  // namespace

std::optional<std::string> CalibrateOptions::invalid() const {
  for (const auto* sum : {&terms, &search_terms}) {
    for (const TermOptions& term : *sum) {
      if (auto wrong = term.invalid()) return "terms: " + *wrong;
    }
  }
  if (coarse.empty() && (screen.survivors > 0 || restarts > 0 || splits > 0)) {
    return "coarse must have at least one level, or nothing can be screened, restarted or split";
  }
  if (fine.empty()) return "fine must have at least one level";
  for (const auto* levels : {&coarse, &fine}) {
    for (const Level& level : *levels) {
      if (auto wrong = level.invalid()) return "level: " + *wrong;
    }
  }
  if (auto wrong = screen.invalid()) return "screen: " + *wrong;
  if (!(screen_sigma >= 0)) return "screen_sigma must not be negative";
  if (screen_points < 100) return "screen_points must be at least 100";
  if (coarse_points < 100) return "coarse_points must be at least 100";
  if (!(initial_translation_sigma > 0)) return "initial_translation_sigma must be positive";
  if (restarts < 0) return "restarts must not be negative";
  if (restarts > 0 && restarts_of_few < restarts) {
    return "restarts_of_few must not be less than restarts";
  }
  if (fine_restarts < 0) return "fine_restarts must not be negative";
  if (!(fine_restart_rotation >= 0)) return "fine_restart_rotation must not be negative";
  if (!(fine_restart_translation >= 0)) return "fine_restart_translation must not be negative";
  if (splits < 0) return "splits must not be negative";
  if (!(restart_rotation >= 0)) return "restart_rotation must not be negative";
  if (!(restart_translation >= 0)) return "restart_translation must not be negative";
  if (!(support_sigma >= 0)) return "support_sigma must not be negative";
  if (!(min_support >= 0 && min_support <= 1)) return "min_support must be between 0 and 1";
  if (!(max_rotation_sigma > 0)) return "max_rotation_sigma must be positive";
  if (!(max_translation_sigma > 0)) return "max_translation_sigma must be positive";
  if (auto wrong = known.invalid()) return "known: " + *wrong;
  if (auto wrong = maximize.invalid()) return "maximize: " + *wrong;
  if (auto wrong = visibility.invalid()) return "visibility: " + *wrong;
  return std::nullopt;
}

Level quick_level(const CalibrateOptions& options) {
  return {
      .sigma = options.fine[options.fine.size() / 2].sigma, .points = 60'000, .tolerance = 5e-3};
}

std::vector<ImageBlur> image_blurs(const CalibrateOptions& options) {
  std::vector<ImageBlur> blurs{ImageBlur::in_angle(options.screen_sigma),
                               ImageBlur::in_angle(options.support_sigma)};
  for (const auto* levels : {&options.coarse, &options.fine}) {
    for (const Level& level : *levels) blurs.push_back(ImageBlur::in_angle(level.sigma));
  }
  if (options.check_intrinsics) {
    const std::vector<ImageBlur> further = intrinsics_blurs();
    blurs.insert(blurs.end(), further.begin(), further.end());
  }
  return blurs;
}

CalibrationResult calibrate(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                            const Eigen::Isometry3d& T_refcam_lidar_initial,
                            const CalibrateOptions& options) {
  CalibrationSteps calibration(scenes, cameras, T_refcam_lidar_initial, options);
  CalibrationResult result =
      run_attempt(calibration, T_refcam_lidar_initial, scenes.size(), options, 1);
  // Too few places are too few at every pose.
  const bool enough = calibration.effective_scenes() >= kMinEffectiveScenes;
  if (!result.usable() && enough && options.restarts > 0 && result.points > 0) {
    const CalibrationResult retry =
        run_attempt(calibration, T_refcam_lidar_initial, scenes.size(), options, kRetryPriorScale);
    // The same maximum fails for the same reasons.
    if (retry.usable() && !is_same_maximum(retry.T_refcam_lidar, result.T_refcam_lidar)) {
      result = retry;
    }
  }
  if (result.usable()) result.split_half = calibration.split_half(result.T_refcam_lidar);
  result.evaluations += calibration.evaluations();
  return result;
}

}  // namespace infuse::calibration
