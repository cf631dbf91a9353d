#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "fusion/dependence/least_squares.hpp"
#include "fusion/streetmap/global_search.hpp"
#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/local_grid.hpp"
#include "fusion/streetmap/view_score.hpp"

namespace infuse::streetmap {

/// How the particles live.
struct ParticleOptions {
  int min_count = 100;            ///< particles, when all agree
  int max_count = 800;            ///< particles, when they are spread out
  double bin_size = 0.6;          ///< m: edge of the bins that tell how spread out they are
  double yaw_bin_size = 0.035;    ///< rad
  double distance_noise = 0.015;  ///< m per √m driven, beside the odometry's own covariance
  double scale_sigma = 0.01;      ///< of true over measured distance, which each particle carries
  double scale_correlation_distance = 4000;  ///< m driven after which it may be another
  double yaw_rate_bias_sigma = 0.001;        ///< rad/s, of true minus measured yaw rate, the same
  double yaw_rate_bias_correlation_time = 600;  ///< s after which it may be another
  double yaw_noise = 8e-4;                      ///< rad per √m driven, the same
  double yaw_noise_per_update = 2e-4;           ///< rad an update, the same
  double kernel_width = 0.4;  ///< of resampling, a share of the particles' own deviations
  double jitter = 0.03;       ///< m, after resampling: keeps copies apart
  double jitter_yaw = 0.002;  ///< rad

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// When the tracker believes itself.
struct ConfidenceOptions {
  int null_draws = 10;  ///< scores of displaced poses an update, the null distribution
  int window = 12;      ///< updates over which scores are compared with their null
  double max_tracking_p_value =
      0.05;                          ///< p-value below which it is TRACKING, if also not spread out
  double min_lost_p_value = 0.35;    ///< p-value above which it is LOST
  double max_tracking_spread = 2.0;  ///< m, deviation along the worst direction; above: UNSURE
  double min_lost_spread = 12.0;     ///< m; above: LOST
  double max_tracking_yaw_sigma = 0.1;           ///< rad, deviation; above: UNSURE
  double max_tracking_second_mode_weight = 0.2;  ///< weight of a second place; above: UNSURE
  double search_radius = 12.0;                   ///< m within which it looks for itself when LOST
  double search_yaw = 0.25;                      ///< rad
  double map_sigma = 0.55;  ///< m: how far the map is from the world; added to the covariance

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Settings of the tracker.
struct TrackerOptions {
  LocalGridOptions grid;
  Labelling labelling = Labelling::kKinds;
  ViewMeasure measure = ViewMeasure::kLsmi;
  dependence::FitOptions fit{
      .centres = 40, .sigmas = {1.0, 1.5, 2.2, 3.3}, .lambdas = {1e-4, 1e-3, 1e-2, 1e-1}};
  double skipped_validation_share =
      0.9;                       ///< share of particles whose cross-validation is left out, I 3.3.2
  double max_validated = 16;     ///< particles an update that are cross-validated, in the mean
  double min_motion = 0.3;       ///< m between updates: what is seen from one place counts once
  double min_rotation = 0.03;    ///< rad, the same
  double sharpness = 8;          ///< log-weight per unit of SMI of a view that is wholly new
  double novelty_distance = 40;  ///< m driven until it is: views that overlap, and a map that is
                                 ///< wrong for tens of metres, are no independent evidence
  double novelty_seconds = 4;  ///< s of driving, which add to that: odometry drifts at a walk, too
  ParticleOptions particles;
  ConfidenceOptions confidence;
  GlobalSearchOptions global_search;
  uint64_t seed = 1;

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::streetmap
