#include "fusion/streetmap/global_search.hpp"

namespace infuse::streetmap {

GlobalSearch::Candidate GlobalSearch::draw(const PlanarPose& estimate) {
  const double longitudinal = options_.longitudinal_sigma * normal_(random_);
  const double lateral = options_.lateral_sigma * normal_(random_);
  const PlanarPose pose =
      estimate.compose({longitudinal, lateral, options_.yaw_sigma * normal_(random_)});
  return {transform_between(estimate, pose)};
}

// What lies in the region of the estimate is no other place: there the particles decide.
std::optional<PlanarPose> GlobalSearch::update(
    const PlanarPose& estimate, const Eigen::Matrix2d& covariance, double estimate_score,
    double novelty, double gain, const std::function<double(const PlanarPose&)>& score) {
  if (options_.count == 0) return std::nullopt;
  if (candidates_.empty()) {
    for (int i = 0; i < options_.count; ++i) candidates_.push_back(draw(estimate));
    novelty_sum_ = 0;
  }
  novelty_sum_ += novelty;
  const bool give_up = novelty_sum_ >= options_.comparison_views;
  std::optional<PlanarPose> found;
  double best = 0;
  for (Candidate& candidate : candidates_) {
    const PlanarPose pose = candidate.T.compose(estimate);
    candidate.log_odds += gain * (score(pose) - estimate_score);
    if (candidate.log_odds <= 0 || is_in_region(pose, estimate, covariance)) {
      if (give_up) candidate = draw(estimate);
    } else if (candidate.log_odds > best && place_.is_better(candidate.log_odds)) {
      best = candidate.log_odds;
      found = pose;
    }
  }
  if (give_up) novelty_sum_ = 0;
  if (found) reset();
  return found;
}

}  // namespace infuse::streetmap
