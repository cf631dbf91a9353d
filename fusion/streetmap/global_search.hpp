#pragma once

#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"

namespace infuse::streetmap {

/// How the scouts look around.
struct GlobalSearchOptions {
  int count = 40;                 ///< poses that are tried; 0: none
  double longitudinal_sigma = 7;  ///< m, deviation along the heading: where streets look alike
  double lateral_sigma = 2.5;     ///< m
  double yaw_sigma = 0.04;        ///< rad
  double comparison_views = 3;  ///< wholly new views over which they are compared with the estimate
  double min_advantage = 0.04;  ///< SMI by which one must be better than the estimate, in the mean
  double min_distance = 1.5;    ///< m within which a scout is no other place than the estimate
};

/// Poses around the estimate that are tried for some views: particles that agree on a wrong place
/// would never look elsewhere.
class GlobalSearch {
 public:
  GlobalSearch(const GlobalSearchOptions& options, uint64_t seed)
      : options_(options), random_(seed) {}

  /// Sends all out anew from their next update.
  void reset() { poses_.clear(); }

  /// Moves all with the vehicle.
  void move(const PlanarPose& motion);

  /// Scores all by a view of which the share `news` is new; `estimate_score` is that of `estimate`.
  /// After `patience` new views gives the best one where it is better than the estimate by the
  /// advantage, and sends all out anew.
  std::optional<PlanarPose> update(const PlanarPose& estimate, double estimate_score,
                                   double novelty,
                                   const std::function<double(const PlanarPose&)>& score);

 private:
  void draw_poses(const PlanarPose& estimate);

  GlobalSearchOptions options_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<PlanarPose> poses_;
  std::vector<double> score_sums_;
  double estimate_score_sum_ = 0;
  double novelty_sum_ = 0;
};

}  // namespace infuse::streetmap
