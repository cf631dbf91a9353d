#include "fusion/streetmap/tracker_options.hpp"

namespace infuse::streetmap {

std::optional<std::string> ParticleOptions::invalid() const {
  if (min_count < 10 || max_count < min_count || max_count > 100'000) {
    return "particles: 10 ≤ min_count ≤ max_count ≤ 100000 is required";
  }
  if (!(bin_size > 0 && yaw_bin_size > 0))
    return "particles: bin_size and yaw_bin_size must be positive";
  for (const double noise : {distance_noise, scale_sigma, yaw_rate_bias_sigma, yaw_noise,
                             yaw_noise_per_update, jitter, jitter_yaw}) {
    if (!(noise >= 0 && noise <= 1)) return "particles: noise must be between 0 and 1";
  }
  if (!(kernel_width >= 0 && kernel_width < 1))
    return "particles: kernel_width must be between 0 and 1";
  if (!(scale_correlation_distance > 0 && yaw_rate_bias_correlation_time > 0)) {
    return "particles: scale_correlation_distance and yaw_rate_bias_correlation_time must be "
           "positive";
  }
  return std::nullopt;
}

std::optional<std::string> ConfidenceOptions::invalid() const {
  if (null_draws < 1 || window < 1 || null_draws > 1000 || window > 1000) {
    return "confidence: null_draws and window must be between 1 and 1000";
  }
  if (!(max_tracking_p_value > 0 && max_tracking_p_value < max_kept_p_value &&
        max_kept_p_value <= 1)) {
    return "confidence: 0 < max_tracking_p_value < max_kept_p_value ≤ 1 is required";
  }
  if (!(max_tracking_spread > 0 && max_tracking_yaw_sigma > 0)) {
    return "confidence: max_tracking_spread and max_tracking_yaw_sigma must be positive";
  }
  if (!(map_sigma >= 0)) return "confidence: map_sigma must not be negative";
  return std::nullopt;
}

std::optional<std::string> TrackerOptions::invalid() const {
  if (auto wrong = grid.invalid()) return wrong;
  if (auto wrong = fit.invalid()) return wrong;
  if (auto wrong = particles.invalid()) return wrong;
  if (auto wrong = confidence.invalid()) return wrong;
  if (auto wrong = place_check.invalid()) return wrong;
  if (auto wrong = gnss.invalid()) return wrong;
  if (auto wrong = global_start.invalid()) return wrong;
  if (global_search.count < 0 || global_search.count > 10'000 ||
      !(global_search.comparison_views > 0)) {
    return "global_search: count must be between 0 and 10000, comparison_views positive";
  }
  if (!(skipped_validation_share >= 0 && skipped_validation_share <= 1))
    return "skipped_validation_share must be between 0 and 1";
  if (!(max_validated > 0)) return "max_validated must be above 0";
  if (!(novelty_seconds > 0)) return "novelty_seconds must be above 0";
  if (!(min_motion >= 0 && min_rotation >= 0)) return "min_motion must not be negative";
  if (!(sharpness > 0 && sharpness <= 1e4)) return "sharpness must be between 0 and 10000";
  if (!(novelty_distance > 0)) return "novelty_distance must be positive";
  return std::nullopt;
}

}  // namespace infuse::streetmap
