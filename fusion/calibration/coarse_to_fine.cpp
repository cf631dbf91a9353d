#include "fusion/calibration/coarse_to_fine.hpp"

#include <algorithm>

namespace infuse::calibration {
std::optional<std::string> Level::invalid() const {
  if (!(sigma >= 0)) return "sigma must not be negative";
  if (passes < 1) return "passes must be at least 1";
  if (!(tolerance > 0)) return "tolerance must be positive";
  if (!(anchor >= 0)) return "anchor must not be negative";
  if (survivors < 1) return "survivors must be at least 1";
  return std::nullopt;
}

CoarseToFine::CoarseToFine(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                           std::span<const TermOptions> terms, ImagePyramid& images,
                           const VisibilityOptions& visibility, const MaximizeOptions& maximize,
                           const Eigen::Vector3d& known, double known_to)
    : scenes_(scenes),
      cameras_(cameras),
      terms_(terms),
      images_(images),
      visibility_(visibility),
      maximize_(maximize),
      known_(known),
      known_to_(known_to) {}

VisiblePoints CoarseToFine::visible(const Eigen::Isometry3d& T_head_lidar, size_t most) const {
  VisibilityOptions visibility = visibility_;
  visibility.max_points = most;
  return select_visible(scenes_, cameras_, T_head_lidar, visibility);
}

Objective CoarseToFine::objective(const VisiblePoints& points, double sigma) {
  return {points, images_.at(sigma), cameras_, scenes_, terms_};
}

Maximum CoarseToFine::climb_once(const Eigen::Isometry3d& start, const Level& level) {
  if (maximize_.stop.stop_requested()) return {.T_head_lidar = start, .reason = kCancelled};
  const VisiblePoints points = visible(start, level.points);
  Objective measure = objective(points, level.sigma);
  MaximizeOptions options = maximize_;
  options.tolerance = level.tolerance;
  if (level.anchor > 0) {
    const double value = measure.evaluate(start, false).estimate.value;
    options.anchor = {.centre = known_,
                      .weight = 2 * level.anchor * std::max(value, 0.0) / (known_to_ * known_to_)};
  }
  const Maximum maximum = maximize(measure, start, options);
  evaluations_ += measure.evaluations();
  return maximum;
}

Maximum CoarseToFine::climb(const Eigen::Isometry3d& start, std::span<const Level> levels) {
  Maximum at{.T_head_lidar = start};
  for (const Level& level : levels) {
    for (int pass = 0; pass < level.passes; ++pass) at = climb_once(at.T_head_lidar, level);
  }
  return at;
}

}  // namespace infuse::calibration
