#include "fusion/calibration/rotation_screen.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {
namespace {

struct ScoredRotation {
  Eigen::Vector3d rotation;  ///< rad, of the camera
  double score;
};

/// Returns point k of a sequence that fills the cube [−1, 1]³ evenly: multiples of the powers of
/// 1/g, g the real root of x⁴ = x + 1, each modulo 1.
Eigen::Vector3d low_discrepancy_point(int k) {
  constexpr double kRoot = 1.2207440846057596;  // g by definition
  Eigen::Vector3d point;
  double power = 1;
  for (int axis = 0; axis < 3; ++axis) {
    power /= kRoot;
    const double at = 0.5 + power * (k + 1);
    point(axis) = 2 * (at - std::floor(at)) - 1;
  }
  return point;
}

class RotationScreening {
 public:
  RotationScreening(const Eigen::Isometry3d& initial_pose, const ScreenOptions& options,
                    const std::function<double(const Eigen::Isometry3d&)>& score)
      : initial_pose_(initial_pose), options_(options), score_(score) {}

  std::vector<Eigen::Isometry3d> run() {
    const double poses_per_axis = 2 * options_.half_width / options_.spacing;
    const double wanted = std::ceil(std::pow(poses_per_axis, 3));
    const int first = static_cast<int>(std::min<double>(wanted, options_.max_poses));
    score_around(Eigen::Vector3d::Zero(), options_.half_width, first);
    if (wanted > first) refine(2 * options_.half_width / std::cbrt(first));
    return best();
  }

 private:
  Eigen::Isometry3d rotated(const Eigen::Vector3d& turn) const {
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist.head<3>() = turn;
    return geometry::exp(twist) * initial_pose_;
  }

  void score_around(const Eigen::Vector3d& centre, double half_width, int count) {
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d turn = centre + half_width * low_discrepancy_point(k);
      scored_.push_back({turn, score_(rotated(turn))});
    }
  }

  void sort_by_score() {
    std::stable_sort(
        scored_.begin(), scored_.end(),
        [](const ScoredRotation& a, const ScoredRotation& b) { return a.score > b.score; });
  }

  /// Scores poses around the best of a round whose spacing is `apart`.
  void refine(double apart) {
    constexpr size_t kMaxRefinedPoses = 24;
    sort_by_score();
    const std::vector<ScoredRotation> centres(
        scored_.begin(),
        scored_.begin() + static_cast<std::ptrdiff_t>(std::min(kMaxRefinedPoses, scored_.size())));
    const int each = static_cast<int>(std::ceil(std::pow(apart / options_.spacing, 3)));
    for (const ScoredRotation& centre : centres)
      score_around(centre.rotation, apart / 2, std::min(each, 12));
  }

  std::vector<Eigen::Isometry3d> best() {
    sort_by_score();
    std::vector<Eigen::Isometry3d> poses{initial_pose_};
    std::vector<Eigen::Vector3d> taken{Eigen::Vector3d::Zero()};
    for (const ScoredRotation& candidate : scored_) {
      if (static_cast<int>(poses.size()) > options_.survivors) break;
      const bool close = std::any_of(taken.begin(), taken.end(), [&](const auto& turn) {
        return (turn - candidate.rotation).norm() < options_.spacing / 2;
      });
      if (close) continue;
      taken.push_back(candidate.rotation);
      poses.push_back(rotated(candidate.rotation));
    }
    return poses;
  }

  Eigen::Isometry3d initial_pose_;
  const ScreenOptions& options_;
  const std::function<double(const Eigen::Isometry3d&)>& score_;
  std::vector<ScoredRotation> scored_;
};

}  // namespace

std::optional<std::string> ScreenOptions::invalid() const {
  if (!(half_width >= 0 && half_width <= M_PI)) return "half_width must be between 0 and pi";
  if (!(spacing > 0)) return "spacing must be positive";
  if (max_poses < 1 || max_poses > 1'000'000) return "max_poses must be between 1 and 1000000";
  if (survivors < 0) return "survivors must not be negative";
  return std::nullopt;
}

std::vector<Eigen::Isometry3d> screen_rotations(
    const Eigen::Isometry3d& initial_pose, const ScreenOptions& options,
    const std::function<double(const Eigen::Isometry3d&)>& score) {
  if (options.half_width == 0 || options.survivors == 0) return {initial_pose};
  return RotationScreening(initial_pose, options, score).run();
}

}  // namespace infuse::calibration
