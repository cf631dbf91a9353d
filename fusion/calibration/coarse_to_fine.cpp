#include "fusion/calibration/coarse_to_fine.hpp"

#include <array>
#include <utility>

namespace infuse::calibration {
namespace {

/// Of the measure at the start: what anchored levels take off one standard deviation from where the
/// translation is known to be.
constexpr double kAnchorShare = 0.8;

}  // namespace

std::optional<std::string> Level::invalid() const {
  if (!(sigma >= 0)) return "sigma must not be negative";
  if (passes < 1) return "passes must be at least 1";
  if (!(tolerance > 0)) return "tolerance must be positive";
  return std::nullopt;
}

CoarseToFine::CoarseToFine(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                           std::vector<TermOptions> terms, const VisibilityOptions& visibility,
                           const MaximizeOptions& maximize, const Eigen::Vector3d& known,
                           double known_to)
    : scenes_(scenes),
      cameras_(cameras),
      terms_(std::move(terms)),
      visibility_(visibility),
      maximize_(maximize),
      known_(known),
      known_to_(known_to) {}

const BlurredImages& CoarseToFine::images(double sigma) {
  // The most blurred of those that are blurred less, if any: they need the least work.
  const auto next = images_.lower_bound(sigma);
  if (next != images_.end() && next->first == sigma) return next->second;
  if (next == images_.begin())
    return images_.try_emplace(sigma, scenes_, terms_, sigma).first->second;
  return images_.try_emplace(sigma, std::prev(next)->second, sigma).first->second;
}

VisiblePoints CoarseToFine::visible(std::span<const Eigen::Isometry3d> poses, size_t most) const {
  VisibilityOptions visibility = visibility_;
  visibility.max_points = most;
  return select_visible(scenes_, cameras_, poses, visibility);
}

Objective CoarseToFine::objective(const VisiblePoints& points, double sigma) {
  return {points, images(sigma), cameras_, scenes_, terms_};
}

Maximum CoarseToFine::climb_once(const Eigen::Isometry3d& start, const Level& level) {
  const VisiblePoints points = visible(std::span(&start, 1), level.points);
  Objective measure = objective(points, level.sigma);
  MaximizeOptions options = maximize_;
  options.tolerance = level.tolerance;
  if (level.anchored) {
    const double value = measure.evaluate(start, false).estimate.value;
    options.anchor = {.translation = known_,
                      .weight = 2 * kAnchorShare * std::max(value, 0.0) / (known_to_ * known_to_)};
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

const Eigen::Isometry3d& CoarseToFine::better(const Eigen::Isometry3d& a,
                                              const Eigen::Isometry3d& b, const Level& level) {
  const VisiblePoints points = visible(std::array{a, b}, level.points);
  Objective measure = objective(points, level.sigma);
  const dependence::Estimate of_a = measure.evaluate(a, false).estimate;
  const dependence::Estimate of_b = measure.evaluate(b, false).estimate;
  evaluations_ += measure.evaluations();
  return of_b.usable() && of_b.value > of_a.value ? b : a;
}

}  // namespace infuse::calibration
