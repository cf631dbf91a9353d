#include "fusion/mapping/closure_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/mapping/drive_join.hpp"
#include "fusion/mapping/position_grid.hpp"

namespace infuse::mapping {
namespace {

constexpr double kSearchCell = 16;  // m, of the grids; bounds time

/// Pose of one keyframe as seen from another, and the standard deviation of its position, m.
struct Relative {
  Eigen::Isometry3d T_from_to;
  double sigma = 0;
};

/// Where the keyframes are taken to be while closures are sought.
class Estimate {
 public:
  Estimate(const std::vector<Keyframe>& keyframes, const std::vector<DriveJoin>& joins,
           const std::optional<KnownPoses>& known)
      : keyframes_(keyframes),
        joins_(joins),
        known_(known),
        poses_(keyframes.size()),
        P_(keyframes.size()) {
    poses_[0] = keyframes[0].T_odom_vehicle;
    P_[0].setZero();
  }

  /// Goes on to keyframe k by odometry, or to where its drive joins those before.
  void advance(size_t k) {
    if (k == 0) return;
    if (next_join_ < joins_.size() && joins_[next_join_].first == k) {
      begin(joins_[next_join_++]);
      return;
    }
    poses_[k] =
        poses_[k - 1] * (keyframes_[k - 1].T_odom_vehicle.inverse() * keyframes_[k].T_odom_vehicle);
    P_[k] = P_[k - 1] + geometry::transform_covariance(poses_[k - 1], keyframes_[k].covariance);
    if (next_join_ == 0) return;
    for (const Closure& closure : joins_[next_join_ - 1].closures) {
      if (closure.to == k) correct(closure);
    }
  }

  /// First keyframe of the drive that was advanced to last.
  size_t first_of_drive() const { return next_join_ == 0 ? 0 : joins_[next_join_ - 1].first; }

  /// Puts its keyframe where a closure has it.
  void correct(const Closure& closure) {
    poses_[closure.to] = poses_[closure.from] * closure.T_from_to;
    P_[closure.to] =
        P_[closure.from] + geometry::transform_covariance(poses_[closure.from], closure.covariance);
  }

  /// Lets a keyframe that was advanced to be found by `for_each_near`.
  void settle(size_t k) {
    tracked_.add(k, poses_[k].translation());
    if (known_) known_grid_.add(k, known_->T_map_vehicle[k].translation());
  }

  /// Calls use(i) at least once for every settled keyframe that is within `radius` (m) of keyframe
  /// k, by the poses that `relative` uses.
  template <class Use>
  void for_each_near(size_t k, double radius, Use use) const {
    tracked_.for_each_near(poses_[k].translation(), radius, use);
    if (known_) known_grid_.for_each_near(known_->T_map_vehicle[k].translation(), radius, use);
  }

  /// By the odometry and the closures so far, or where they are less certain by the known poses.
  Relative relative(size_t from, size_t to) const {
    const double sigma = tracked_sigma(from, to);
    if (known_ && std::sqrt(2.0) * known_->sigma < sigma) {
      return {known_->T_map_vehicle[from].inverse() * known_->T_map_vehicle[to],
              std::sqrt(2.0) * known_->sigma};
    }
    return {poses_[from].inverse() * poses_[to], sigma};
  }

 private:
  void begin(const DriveJoin& join) {
    const Closure& closure = join.closures.front();
    correct(closure);
    if (closure.to == join.first) return;
    const OdometryBetween back = odometry_between(keyframes_, closure.to, join.first);
    poses_[join.first] = poses_[closure.to] * back.T_from_to;
    P_[join.first] =
        P_[closure.to] + geometry::transform_covariance(poses_[closure.to], back.covariance);
  }

  double tracked_sigma(size_t from, size_t to) const {
    Eigen::Matrix<double, 3, 6> G;
    G << -geometry::skew(poses_[to].translation()), Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d C = G * (P_[to] - P_[from]) * G.transpose();
    return std::sqrt(std::max({C(0, 0) + C(1, 1), C(2, 2), 0.0}));
  }

  const std::vector<Keyframe>& keyframes_;
  const std::vector<DriveJoin>& joins_;
  const std::optional<KnownPoses>& known_;
  size_t next_join_ = 0;
  std::vector<Eigen::Isometry3d> poses_;
  PositionGrid tracked_{kSearchCell}, known_grid_{kSearchCell};
  std::vector<geometry::Matrix6> P_;  // left perturbation in the odometry frame
};

struct Candidate {
  size_t from = 0;
  Eigen::Isometry3d T_from_to;
  double distance = 0, margin = 0;  // m
};

std::optional<Candidate> nearest_before(const std::vector<Keyframe>& keyframes,
                                        const Estimate& estimate, size_t k,
                                        const ClosureSearchOptions& options) {
  std::optional<Candidate> best;
  const size_t first = estimate.first_of_drive();
  estimate.for_each_near(k, options.max_distance + options.max_search, [&](size_t i) {
    const double driven = keyframes[k].distance_driven - keyframes[i].distance_driven;
    if (!keyframes[i].has_cloud || (i >= first && driven < options.min_distance_driven)) return;
    const Relative relative = estimate.relative(i, k);
    const double distance = relative.T_from_to.translation().norm();
    if (best && (distance > best->distance || (distance == best->distance && i >= best->from)))
      return;
    const double margin = std::min(options.sigmas * relative.sigma, options.max_search);
    if (distance <= options.max_distance + margin) {
      best = Candidate{i, relative.T_from_to, distance, margin};
    }
  });
  return best;
}

/// Whether a verified closure lies beyond what the uncertainty of its candidate allows.
bool contradicts(const Closure& closure, const Candidate& candidate,
                 const ClosureSearchOptions& options) {
  const Eigen::Vector3d moved = closure.T_from_to.translation() - candidate.T_from_to.translation();
  return moved.norm() > options.max_distance + candidate.margin;
}

}  // namespace

std::optional<std::string> ClosureSearchOptions::invalid() const {
  for (const double length :
       {min_distance_driven, max_distance, sigmas, max_search, max_guess_error}) {
    if (!(length > 0)) return "lengths must be positive";
  }
  if (!(spacing >= 0 && search_spacing >= 0)) return "spacings must not be negative";
  return std::nullopt;
}

Result<std::vector<Closure>> search_closures(const std::vector<Keyframe>& keyframes,
                                             const std::vector<DriveJoin>& joins,
                                             const std::vector<Closure>& earlier,
                                             const std::optional<KnownPoses>& known,
                                             const ClosureSearchOptions& options,
                                             const VerifyClosure& verify) {
  std::vector<Closure> closures;
  if (keyframes.empty()) return closures;
  Estimate estimate(keyframes, joins, known);
  // Distance driven at which closures are sought again.
  double next = -std::numeric_limits<double>::infinity();
  size_t next_earlier = 0;
  for (size_t k = 0; k < keyframes.size(); ++k) {
    if (k > 0) estimate.settle(k - 1);
    estimate.advance(k);
    for (; next_earlier < earlier.size() && earlier[next_earlier].to == k; ++next_earlier) {
      estimate.correct(earlier[next_earlier]);
      // Where the other keyframe has left its cloud to this one, this one seeks in its stead.
      if (keyframes[earlier[next_earlier].from].has_cloud) {
        next = keyframes[k].distance_driven + options.spacing;
      }
    }
    if (keyframes[k].distance_driven < next || !keyframes[k].has_cloud) continue;
    const auto candidate = nearest_before(keyframes, estimate, k, options);
    if (!candidate) continue;
    Closure closure;
    closure.from = candidate->from;
    closure.to = k;
    closure.guessed = candidate->margin <= options.sigmas * options.max_guess_error;
    closure.T_from_to = candidate->T_from_to;
    const auto verified = verify(closure);
    if (!verified) return tl::unexpected(verified.error());
    if (closure.accepted() && contradicts(closure, *candidate, options))
      closure.reason = "the odometry since then contradicts";
    if (closure.accepted()) estimate.correct(closure);
    next = keyframes[k].distance_driven + (closure.accepted() ? options.spacing
                                           : closure.guessed  ? 0
                                                              : options.search_spacing);
    closures.push_back(std::move(closure));
  }
  return closures;
}

}  // namespace infuse::mapping
