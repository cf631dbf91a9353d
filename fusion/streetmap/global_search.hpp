#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "fusion/streetmap/place_check.hpp"
#include "fusion/streetmap/planar_pose.hpp"

namespace infuse::streetmap {

/// Settings of `GlobalSearch`.
struct GlobalSearchOptions {
  int count = 40;                 ///< number of candidate poses; 0: no search
  double longitudinal_sigma = 7;  ///< m, standard deviation of the candidates along the heading, in
                                  ///< which streets are self-similar
  double lateral_sigma = 2.5;     ///< m, standard deviation across the heading
  double yaw_sigma = 0.04;        ///< rad, standard deviation
  double comparison_views = 3;    ///< independent views after which what fits no better is given up
};

/// Candidate poses around the estimate that are evaluated over many views. They find another place
/// on the map when all particles agree on a wrong one.
class GlobalSearch {
 public:
  /// `place`: what another place needs to be proposed.
  GlobalSearch(const GlobalSearchOptions& options, const PlaceCheckOptions& place, uint64_t seed)
      : options_(options), place_(place), random_(seed) {}

  /// Draws new candidates at the next update.
  void reset() { candidates_.clear(); }

  /// Evaluates all candidates, which drive with the estimate, on a view of which the share
  /// `novelty` is new. `covariance` of the estimate on the map (`is_in_region`), `estimate_score`
  /// its score; `gain`: log-odds per unit of score of the view. Returns a candidate once its views
  /// make it likelier than the estimate, and draws new ones.
  std::optional<PlanarPose> update(const PlanarPose& estimate, const Eigen::Matrix2d& covariance,
                                   double estimate_score, double novelty, double gain,
                                   const std::function<double(const PlanarPose&)>& score);

 private:
  struct Candidate {
    PlanarPose T;  // of the estimate to this pose, map frame
    double log_odds = 0;
  };
  Candidate draw(const PlanarPose& estimate);

  GlobalSearchOptions options_;
  PlaceCheckOptions place_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<Candidate> candidates_;
  double novelty_sum_ = 0;  // since candidates were given up
};

}  // namespace infuse::streetmap
