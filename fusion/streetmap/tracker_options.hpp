#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "fusion/dependence/least_squares.hpp"
#include "fusion/streetmap/global_search.hpp"
#include "fusion/streetmap/global_start.hpp"
#include "fusion/streetmap/gnss_witness.hpp"
#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/local_grid.hpp"
#include "fusion/streetmap/place_check.hpp"

namespace infuse::streetmap {

/// Settings of `ParticleSet`.
struct ParticleOptions {
  int min_count = 100;          ///< number of particles while they agree, I 3.4.3.1
  int max_count = 800;          ///< number of particles while they are spread out
  double bin_size = 0.6;        ///< m: edge of the bins that measure the spread
  double yaw_bin_size = 0.035;  ///< rad
  double distance_noise =
      0.015;                  ///< m per √m driven, in addition to the covariance of the odometry
  double scale_sigma = 0.01;  ///< of true over measured distance; derived from
                              ///< `motion::OdometryOptions::wheel_scale_sigma`
  double scale_correlation_distance = 4000;  ///< m driven
  double yaw_rate_bias_sigma =
      0.001;  ///< rad/s, standard deviation of true minus measured yaw rate
  double yaw_rate_bias_correlation_time = 600;  ///< s
  double yaw_noise = 8e-4;                      ///< rad per √m driven
  double yaw_noise_per_update = 2e-4;           ///< rad per update
  double kernel_width = 0.4;  ///< width of the resampling kernel as a share of the standard
                              ///< deviations of the particles
  double jitter = 0.03;       ///< m, after resampling, separates copies
  double jitter_yaw = 0.002;  ///< rad

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Thresholds of the states TRACKING, UNSURE and LOST.
struct ConfidenceOptions {
  int null_draws = 10;  ///< number of displaced poses per update, the null distribution
  int window = 12;      ///< updates over which scores are compared with the null distribution
  double max_tracking_p_value = 0.05;  ///< of TRACKING: by chance one in twenty
  double max_kept_p_value = 0.35;      ///< p-value up to which a confirmed place stays TRACKING;
                                       ///< above, it is checked again
  double max_tracking_spread =
      2.0;  ///< m, standard deviation along the worst direction; above: UNSURE
  double max_tracking_yaw_sigma = 0.1;           ///< rad; above: UNSURE
  double max_tracking_second_mode_weight = 0.2;  ///< weight of a second mode; above: UNSURE
  double map_sigma =
      0.55;  ///< m: standard deviation of the map against the world; added to the covariance

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Settings of the tracker.
struct TrackerOptions {
  LocalGridOptions grid;
  Labelling labelling = Labelling::kKinds;
  dependence::FitOptions fit{
      .centres = 40, .sigmas = {1.0, 1.5, 2.2, 3.3}, .lambdas = {1e-4, 1e-3, 1e-2, 1e-1}};
  double skipped_validation_share =
      0.9;                    ///< share of the particles without cross-validation, I 3.3.2
  double max_validated = 16;  ///< mean number of particles per update with cross-validation
  double min_motion =
      0.3;  ///< m, minimum motion between updates: a view from one place counts once
  double min_rotation = 0.03;    ///< rad, minimum rotation between updates
  double sharpness = 8;          ///< log-weight per unit of SMI of a wholly new view
  double novelty_distance = 40;  ///< m driven until a view is wholly new: overlapping views, and a
                                 ///< map error over tens of metres, are no independent evidence
  double novelty_seconds =
      4;  ///< s of driving until a view is wholly new, as odometry also drifts with time
  ParticleOptions particles;
  ConfidenceOptions confidence;
  GlobalSearchOptions global_search;
  PlaceCheckOptions place_check;
  GlobalStartOptions global_start;
  GnssOptions gnss;
  uint64_t seed = 1;

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::streetmap
