#include "fusion/calibration/coarse_to_fine.hpp"

#include <algorithm>

namespace infuse::calibration {

std::optional<std::string> Level::invalid() const {
  if (!(sigma >= 0)) return "sigma must not be negative";
  if (passes < 1) return "passes must be at least 1";
  if (!(tolerance > 0)) return "tolerance must be positive";
  if (!(prior_weight >= 0)) return "prior_weight must not be negative";
  if (survivors < 1) return "survivors must be at least 1";
  return std::nullopt;
}

CoarseToFine::CoarseToFine(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                           std::span<const TermOptions> terms, ImagePyramid& images,
                           const VisibilityOptions& visibility, const MaximizeOptions& maximize,
                           const Eigen::Vector3d& prior_position, double prior_position_sigma)
    : scenes_(scenes),
      cameras_(cameras),
      terms_(terms),
      images_(images),
      visibility_(visibility),
      maximize_(maximize),
      prior_position_(prior_position),
      prior_position_sigma_(prior_position_sigma) {}

VisiblePoints CoarseToFine::visible_points(const Eigen::Isometry3d& T_refcam_lidar,
                                           size_t max_points) const {
  VisibilityOptions visibility = visibility_;
  visibility.max_points = max_points;
  return select_visible(scenes_, cameras_, T_refcam_lidar, visibility);
}

Objective CoarseToFine::make_objective(const VisiblePoints& points, double sigma) {
  return {points, images_.at(ImageBlur::in_angle(sigma)), cameras_, scenes_, terms_};
}

Maximum CoarseToFine::ascend_once(const Eigen::Isometry3d& initial_pose, const Level& level) {
  if (maximize_.stop.stop_requested())
    return {.T_refcam_lidar = initial_pose, .reason = kCancelled};
  const VisiblePoints points = visible_points(initial_pose, level.points);
  Objective measure = make_objective(points, level.sigma);
  MaximizeOptions options = maximize_;
  options.tolerance = level.tolerance;
  if (level.prior_weight > 0) {
    const double value = measure.evaluate(initial_pose, false).estimate.value;
    options.position_prior = {.centre = prior_position_,
                              .weight = 2 * level.prior_weight * std::max(value, 0.0) /
                                        (prior_position_sigma_ * prior_position_sigma_)};
  }
  Maximum maximum = maximize(measure, initial_pose, options);
  evaluations_ += measure.evaluations();
  return maximum;
}

Maximum CoarseToFine::ascend(const Eigen::Isometry3d& initial_pose, std::span<const Level> levels) {
  Maximum at{.T_refcam_lidar = initial_pose};
  for (const Level& level : levels) {
    for (int pass = 0; pass < level.passes; ++pass) at = ascend_once(at.T_refcam_lidar, level);
  }
  return at;
}

}  // namespace infuse::calibration
