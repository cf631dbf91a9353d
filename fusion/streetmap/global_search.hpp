#pragma once

#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"

namespace infuse::streetmap {

/// Settings of `GlobalSearch`.
struct GlobalSearchOptions {
  int count = 40;                 ///< number of candidate poses; 0: no search
  double longitudinal_sigma = 7;  ///< m, standard deviation of the candidates along the heading, in
                                  ///< which streets are self-similar
  double lateral_sigma = 2.5;     ///< m, standard deviation across the heading
  double yaw_sigma = 0.04;        ///< rad, standard deviation
  double comparison_views =
      3;  ///< independent views over which candidates are compared with the estimate
  double min_advantage = 0.04;  ///< SMI, minimum mean advantage of a candidate over the estimate
  double min_distance = 1.5;    ///< m, minimum distance of a candidate from the estimate
};

/// Candidate poses around the estimate that are evaluated over several views. They find another
/// place on the map when all particles agree on a wrong one.
class GlobalSearch {
 public:
  GlobalSearch(const GlobalSearchOptions& options, uint64_t seed)
      : options_(options), random_(seed) {}

  /// Draws new candidates at the next update.
  void reset() { poses_.clear(); }

  /// Moves all candidates with the vehicle.
  void move(const PlanarPose& motion);

  /// Evaluates all candidates on a view of which the share `novelty` is new; `estimate_score` is
  /// the score of `estimate`. After `comparison_views` new views returns the best candidate if it
  /// exceeds the estimate by `min_advantage`, and draws new candidates.
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
