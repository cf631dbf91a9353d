#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>

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
  size_t first_view = 0;            ///< at which the run starts
  size_t max_views = SIZE_MAX;      ///< number of views of the run
  /// Start at this offset from the truth, vehicle frame, instead of a random direction.
  std::optional<PlanarPose> start_offset{};
  std::optional<PlanarPose> start_pose{};  ///< start there instead, map frame
  bool from_nothing = false;               ///< no start is given
  size_t views_after_recovery = SIZE_MAX;  ///< of a run that tracks the truth
  /// Standard deviation per axis of the lasting error of GNSS fixes, m, one each view; the noise of
  /// each is 1 m, and 0.05 rad of the course, which is known above 2 m/s. Nothing: no fixes.
  std::optional<double> gnss_sigma{};
  Eigen::Vector2d gnss_offset{0, 0};     ///< m, map frame, of all fixes
  int bad_fixes = 0;                     ///< number of fixes at first that state an hdop of 15
  Eigen::Vector2d bad_fix_offset{0, 0};  ///< m, map frame, of those
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
  int inside_99 = 0;               ///< TRACKING and the truth within the 99 % region
  double longest_outside = 0;      ///< s TRACKING with the truth outside the 99 % region, in one go
  double metres_to_tracking = -1;  ///< driven until the first TRACKING; below 0: never
  double seconds_to_tracking = -1;    ///< the same in time
  int updates_since_tracking = 0;     ///< updates since the first TRACKING
  bool tracks_truth = false;          ///< TRACKING within 3 m of the truth at the end
  std::map<std::string, int> doubts;  ///< updates by the reason for not TRACKING
  double started_metres = -1;         ///< driven until it has a place within 12 m of the truth
  double recovered_after = -1;        ///< s until it first tracks the truth; below 0: never
  double seconds = 0;                 ///< processor time per view
};

/// Runs over the views once.
RunResult run(const SegmentMap& map, const std::vector<View>& views, const RunOptions& options);

/// Summary over several seeds.
struct Summary {
  double lateral = 0, longitudinal = 0, total = 0, total_sigma = 0,
         yaw = 0;                        ///< means; standard deviation of `total`
  double success = 0;                    ///< share of runs that end within 2 m
  double tracking = 0;                   ///< share of updates
  double lost = 0;                       ///< share of updates
  double inside_99 = 0;                  ///< share of TRACKING updates
  double seconds = 0;                    ///< processor time per view
  std::map<std::string, double> doubts;  ///< share of updates by the reason for not TRACKING
  int runs = 0;
};
Summary run_seeds(const SegmentMap& map, const std::vector<View>& views, RunOptions options,
                  int seeds);

}  // namespace infuse::streetmap::bench
