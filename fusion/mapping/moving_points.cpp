#include "fusion/mapping/moving_points.hpp"

namespace infuse::mapping {

std::optional<std::string> MovingPointsOptions::invalid() const {
  if (!(max_range > 0)) return "max_range must be above 0 m";
  if (!(min_clearance > support)) return "min_clearance must be above support";
  if (!(support > 0)) return "support must be above 0 m";
  if (min_refutations == 0) return "min_refutations must be at least 1";
  if (!(min_ratio >= 0)) return "min_ratio must not be negative";
  return std::nullopt;
}

SubmapView::SubmapView(Submap content) : submap(std::move(content)), ranges(submap.points()) {
  search.build(submap.points());
}

std::vector<bool> find_moving_points(const Submap& submap, std::span<const PlacedView> views,
                                     const MovingPointsOptions& options) {
  std::vector<bool> moving(submap.size());
  const auto max_range = static_cast<float>(options.max_range);
  const auto clearance = static_cast<float>(options.min_clearance);
  const auto support = static_cast<float>(options.support);
  for (size_t i = 0; i < submap.size(); ++i) {
    const Eigen::Vector3d point(submap.x[i], submap.y[i], submap.z[i]);
    size_t refuted = 0, confirmed = 0;
    for (const PlacedView& placed : views) {
      const Eigen::Vector3f p = (placed.T_view_submap * point).cast<float>();
      const float range = p.norm();
      if (!(range > clearance && range < max_range)) continue;
      if (placed.view->search.nearest(p.data(), support, 0).index >= 0) {
        ++confirmed;
      } else if (placed.view->ranges.range_towards(p) > range + clearance) {
        ++refuted;
      }
    }
    moving[i] = refuted >= options.min_refutations &&
                static_cast<double>(refuted) >= options.min_ratio * static_cast<double>(confirmed);
  }
  return moving;
}

Submap without_moving_points(const Submap& submap, const std::vector<bool>& moving) {
  Submap still;
  for (size_t i = 0; i < submap.size(); ++i) {
    if (moving[i]) continue;
    still.x.push_back(submap.x[i]);
    still.y.push_back(submap.y[i]);
    still.z.push_back(submap.z[i]);
    still.reflectivity.push_back(submap.reflectivity[i]);
  }
  return still;
}

}  // namespace infuse::mapping
