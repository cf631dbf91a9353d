#pragma once

#include <functional>
#include <memory>

#include "fusion/streetmap/tracker.hpp"
#include "tests/bench/streetmap_drive.hpp"

/// Repeated runs of the tracker on cached views; seeds vary odometry errors and the filter.
namespace infuse::streetmap::bench {

/// Odometry errors and initial error of a run.
struct RunOptions {
  double scale_sigma = 0.006;  ///< standard deviation of measured over true distance, drawn per run
  double yaw_bias_sigma = 0.001;  ///< rad/s, standard deviation of the yaw-rate bias, drawn per run
  double distance_noise = 0;   ///< standard deviation as a share of each motion, I figure 3.19(b)
  double yaw_rate_noise = 0;   ///< rad/s, of the yaw rate of each motion, the same
  double noise_hz = 2;         ///< noise draws per second
  double initial_error = 0.5;  ///< m, in a random direction; also the stated standard deviation
  double initial_yaw_sigma = 0.05;  ///< rad, the same
  TrackerOptions tracker;
  /// Makes the score of a run; empty: `LsmiScore`.
  std::function<std::unique_ptr<ViewScore>()> score{};
  uint64_t seed = 1;
};

/// Result of a run.
struct RunResult {
  double lateral = 0, longitudinal = 0, total = 0;  ///< m rms, after the first ten views
  double yaw = 0;                                   ///< rad rms
  double final_error = 0;                           ///< m, at the end
  int updates = 0, tracking = 0, lost = 0;
  int inside_99 = 0;   ///< TRACKING and the truth within the 99 % region
  double seconds = 0;  ///< processor time per view
};

/// Runs over the views once.
RunResult run(const SegmentMap& map, const std::vector<View>& views, const RunOptions& options);

/// Summary over several seeds.
struct Summary {
  double lateral = 0, longitudinal = 0, total = 0, total_sigma = 0,
         yaw = 0;        ///< means; standard deviation of `total`
  double success = 0;    ///< share of runs that end within 2 m
  double tracking = 0;   ///< share of updates
  double lost = 0;       ///< share of updates
  double inside_99 = 0;  ///< share of TRACKING updates
  double seconds = 0;    ///< processor time per view
  int runs = 0;
};
Summary run_seeds(const SegmentMap& map, const std::vector<View>& views, RunOptions options,
                  int seeds);

}  // namespace infuse::streetmap::bench
