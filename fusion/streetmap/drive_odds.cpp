#include "fusion/streetmap/drive_odds.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr double kMinElsewhere = 1e-9;  // no probability is known to one in a thousand million
constexpr double kBeside = 0.05;        // of a drive that fits one street by chance: one in twenty

}  // namespace

DriveOdds::DriveOdds(const std::optional<FoundPlace>& found, const GlobalStartOptions& options,
                     const PlanarPose& estimate) {
  if (!found || found->elsewhere > options.max_elsewhere ||
      found->misfit > options.max_mean_misfit) {
    return;
  }
  found_ = found->pose;
  information_ = found->covariance.topLeftCorner<2, 2>().inverse();
  refuted_ = std::log(std::max(found->elsewhere, kMinElsewhere));
  same_place_ = options.same_place;
  estimate_ = at(estimate);
  beside_ = found->sure ? 0 : kBeside;
  if (estimate_ <= refuted_) same_place_ = 0;
}

// Along the street places are as likely as the position that was found allows.
double DriveOdds::at(const PlanarPose& pose) const {
  if (!is_same_place(pose, found_, same_place_)) return refuted_;
  const Eigen::Vector2d d(pose.x - found_.x, pose.y - found_.y);
  return std::max(-d.dot(information_ * d) / 2, refuted_);
}

double DriveOdds::operator()(const PlanarPose& pose) const {
  if (same_place_ == 0) return 0;
  return std::log(beside_ + (1 - beside_) * std::exp(at(pose) - estimate_));
}

}  // namespace infuse::streetmap
