#include "fusion/streetmap/scouts.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {

void Scouts::move(const PlanarPose& motion) {
  for (PlanarPose& pose : poses_) pose = pose.then(motion);
}

void Scouts::send_out(const PlanarPose& estimate) {
  poses_.resize(static_cast<size_t>(options_.count));
  sums_.assign(poses_.size(), 0);
  for (PlanarPose& pose : poses_) {
    const double along = options_.along * normal_(random_);
    const double across = options_.across * normal_(random_);
    pose = estimate.then({along, across, options_.yaw * normal_(random_)});
  }
  estimate_sum_ = 0;
  news_ = 0;
}

std::optional<PlanarPose> Scouts::update(const PlanarPose& estimate, double estimate_score,
                                         double news,
                                         const std::function<double(const PlanarPose&)>& score) {
  if (options_.count == 0) return std::nullopt;
  if (poses_.empty()) send_out(estimate);
  for (size_t i = 0; i < poses_.size(); ++i) sums_[i] += news * score(poses_[i]);
  estimate_sum_ += news * estimate_score;
  news_ += news;
  if (news_ < options_.patience) return std::nullopt;
  const auto best = std::max_element(sums_.begin(), sums_.end());
  const PlanarPose place = poses_[static_cast<size_t>(best - sums_.begin())];
  const bool better = *best - estimate_sum_ > options_.advantage * news_ &&
                      std::hypot(place.x - estimate.x, place.y - estimate.y) > options_.apart;
  poses_.clear();
  if (!better) return std::nullopt;
  return place;
}

}  // namespace infuse::streetmap
