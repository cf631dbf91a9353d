#pragma once

#include <functional>

#include "fusion/streetmap/tracker.hpp"
#include "tests/bench/streetmap_drive.hpp"

/// Runs the tracker repeatedly on cached views: seeds vary the odometry errors and the filter.
namespace infuse::streetmap::bench {

/// Odometry errors and initial pose of a run.
struct RunOptions {
  double scale_sigma =
      0.006;  ///< standard deviation of measured over true distance, drawn once per run
  double yaw_bias_sigma = 0.001;  ///< rad/s, of the yaw rate bias, the same
  double distance_noise = 0;  ///< standard deviation as a fraction of each motion, I fig. 3.19(b)
  double yaw_rate_noise = 0;  ///< rad/s, of the yaw rate of each motion, the same
  double noise_hz = 2;        ///< motions per second with independent noise
  double initial_error =
      0.5;  ///< m, in a direction drawn once per run; also the standard deviation of the prior
  double initial_yaw_sigma = 0.05;  ///< rad, the same
  TrackerOptions tracker;
  uint64_t seed = 1;
};

/// Result of a run.
struct RunResult {
  double lateral = 0, longitudinal = 0, total = 0;  ///< m rms, after the first ten views
  double yaw = 0;                                   ///< rad rms
  double final_error = 0;                           ///< m, error at the end
  int updates = 0, tracking = 0, lost = 0;
  int inside_99 = 0;   ///< TRACKING with the truth inside the 99 % region
  double seconds = 0;  ///< processor time per view
};

/// Runs once over the views.
RunResult run(const SegmentMap& map, const std::vector<View>& views, const RunOptions& options);

/// Summary over several seeds.
struct Summary {
  double lateral = 0, longitudinal = 0, total = 0, total_sigma = 0,
         yaw = 0;        ///< means; standard deviation of `total`
  double success = 0;    ///< fraction of runs that end within 2 m
  double tracking = 0;   ///< fraction of updates
  double lost = 0;       ///< fraction of updates
  double inside_99 = 0;  ///< fraction of the TRACKING updates
  double seconds = 0;    ///< per view
  int runs = 0;
};
Summary run_seeds(const SegmentMap& map, const std::vector<View>& views, RunOptions options,
                  int seeds);

}  // namespace infuse::streetmap::bench
