#pragma once

#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"

namespace infuse::streetmap {

/// How the scouts look around.
struct ScoutOptions {
  int count = 40;           ///< poses that are tried; 0: none
  double along = 7;         ///< m, deviation along the heading: where streets look alike
  double across = 2.5;      ///< m
  double yaw = 0.04;        ///< rad
  double patience = 3;      ///< wholly new views over which they are compared with the estimate
  double advantage = 0.04;  ///< SMI by which one must be better than the estimate, in the mean
  double apart = 1.5;       ///< m within which a scout is no other place than the estimate
};

/// Poses around the estimate that are tried for some views: particles that agree on a wrong place
/// would never look elsewhere.
class Scouts {
 public:
  Scouts(const ScoutOptions& options, uint64_t seed) : options_(options), random_(seed) {}

  /// Sends all out anew from their next update.
  void recall() { poses_.clear(); }

  /// Moves all with the vehicle.
  void move(const PlanarPose& motion);

  /// Scores all by a view of which the share `news` is new; `estimate_score` is that of `estimate`.
  /// After `patience` new views gives the best one where it is better than the estimate by the
  /// advantage, and sends all out anew.
  std::optional<PlanarPose> update(const PlanarPose& estimate, double estimate_score, double news,
                                   const std::function<double(const PlanarPose&)>& score);

 private:
  void send_out(const PlanarPose& estimate);

  ScoutOptions options_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<PlanarPose> poses_;
  std::vector<double> sums_;
  double estimate_sum_ = 0;
  double news_ = 0;
};

}  // namespace infuse::streetmap
