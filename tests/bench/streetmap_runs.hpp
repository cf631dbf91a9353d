#pragma once

#include <functional>

#include "fusion/streetmap/tracker.hpp"
#include "tests/bench/streetmap_drive.hpp"

/// The tracker on cached views, many times: seeds vary the odometry's errors and the filter.
namespace infuse::streetmap::bench {

/// How the odometry of a run is wrong, and where the run begins.
struct RunOptions {
  double scale_sigma = 0.006;     ///< deviation of measured over true distance, drawn once a run
  double yaw_bias_sigma = 0.001;  ///< rad/s, of the yaw rate's bias, the same
  double distance_noise = 0;      ///< deviation as a share of each motion, I fig. 3.19(b)
  double yaw_rate_noise = 0;      ///< rad/s, of each motion's yaw rate, the same
  double noise_hz = 2;            ///< motions a second that have noise of their own
  double initial_error = 0.5;     ///< m, in a direction drawn once a run; also the stated deviation
  double initial_yaw_sigma = 0.05;  ///< rad, the same
  TrackerOptions tracker;
  uint64_t seed = 1;
};

/// What became of a run.
struct RunResult {
  double lateral = 0, longitudinal = 0, total = 0;  ///< m rms, after the first ten views
  double yaw = 0;                                   ///< rad rms
  double final_error = 0;                           ///< m, error at the end
  int updates = 0, tracking = 0, lost = 0;
  int inside_99 = 0;   ///< TRACKING and the truth within the 99 % region
  double seconds = 0;  ///< of processor time a view
};

/// Runs over the views once.
RunResult run(const SegmentMap& map, const std::vector<View>& views, const RunOptions& options);

/// Several seeds together.
struct Summary {
  double lateral = 0, longitudinal = 0, total = 0, total_sigma = 0, yaw = 0;  ///< means; of `total`
  double success = 0;    ///< share of runs that end within 2 m
  double tracking = 0;   ///< share of updates
  double lost = 0;       ///< share of updates
  double inside_99 = 0;  ///< share of the TRACKING ones
  double seconds = 0;    ///< a view
  int runs = 0;
};
Summary run_seeds(const SegmentMap& map, const std::vector<View>& views, RunOptions options,
                  int seeds);

}  // namespace infuse::streetmap::bench
