#include "fusion/streetmap/global_search.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/geometry/plane_length.hpp"

namespace infuse::streetmap {

void GlobalSearch::move(const PlanarPose& motion) {
  for (PlanarPose& pose : poses_) pose = pose.compose(motion);
}

void GlobalSearch::draw_poses(const PlanarPose& estimate) {
  poses_.resize(static_cast<size_t>(options_.count));
  score_sums_.assign(poses_.size(), 0);
  for (PlanarPose& pose : poses_) {
    const double longitudinal = options_.longitudinal_sigma * normal_(random_);
    const double lateral = options_.lateral_sigma * normal_(random_);
    pose = estimate.compose({longitudinal, lateral, options_.yaw_sigma * normal_(random_)});
  }
  estimate_score_sum_ = 0;
  novelty_sum_ = 0;
}

std::optional<PlanarPose> GlobalSearch::update(
    const PlanarPose& estimate, double estimate_score, double novelty,
    const std::function<double(const PlanarPose&)>& score) {
  if (options_.count == 0) return std::nullopt;
  if (poses_.empty()) draw_poses(estimate);
  for (size_t i = 0; i < poses_.size(); ++i) score_sums_[i] += novelty * score(poses_[i]);
  estimate_score_sum_ += novelty * estimate_score;
  novelty_sum_ += novelty;
  if (novelty_sum_ < options_.comparison_views) return std::nullopt;
  const auto best = std::max_element(score_sums_.begin(), score_sums_.end());
  const PlanarPose place = poses_[static_cast<size_t>(best - score_sums_.begin())];
  const bool better =
      *best - estimate_score_sum_ > options_.min_advantage * novelty_sum_ &&
      geometry::plane_length(place.x - estimate.x, place.y - estimate.y) > options_.min_distance;
  poses_.clear();
  if (!better) return std::nullopt;
  return place;
}

}  // namespace infuse::streetmap
