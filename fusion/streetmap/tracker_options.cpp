#include "fusion/streetmap/tracker_options.hpp"

namespace infuse::streetmap {

std::optional<std::string> ParticleOptions::invalid() const {
  if (fewest < 10 || most < fewest || most > 100'000) {
    return "particles: fewest must be 10 at least, most not less and 100000 at most";
  }
  if (!(bin > 0 && bin_yaw > 0)) return "particles: bins must be positive";
  for (const double noise :
       {distance_noise, scale_sigma, rate_sigma, yaw_noise, yaw_rest, jitter, jitter_yaw}) {
    if (!(noise >= 0 && noise <= 1)) return "particles: noise must be within 0 … 1";
  }
  if (!(kernel >= 0 && kernel < 1)) return "particles: kernel must be within 0 … 1";
  if (!(scale_memory > 0 && rate_memory > 0)) {
    return "particles: scale_memory and rate_memory must be positive";
  }
  return std::nullopt;
}

std::optional<std::string> ConfidenceOptions::invalid() const {
  if (null_draws < 1 || window < 1 || null_draws > 1000 || window > 1000) {
    return "confidence: null_draws and window must be 1 … 1000";
  }
  if (!(tracking_p > 0 && tracking_p < lost_p && lost_p <= 1)) {
    return "confidence: 0 < tracking_p < lost_p ≤ 1 is needed";
  }
  if (!(tracking_spread > 0 && tracking_spread < lost_spread && tracking_yaw > 0)) {
    return "confidence: 0 < tracking_spread < lost_spread and tracking_yaw > 0 are needed";
  }
  if (!(search_radius > 0 && search_radius <= 1000 && search_yaw > 0)) {
    return "confidence: search_radius must be 0 … 1000 m, search_yaw positive";
  }
  if (!(map_sigma >= 0)) return "confidence: map_sigma must not be negative";
  return std::nullopt;
}

std::optional<std::string> TrackerOptions::invalid() const {
  if (auto wrong = grid.invalid()) return wrong;
  if (auto wrong = fit.invalid()) return wrong;
  if (auto wrong = particles.invalid()) return wrong;
  if (auto wrong = confidence.invalid()) return wrong;
  if (scouts.count < 0 || scouts.count > 10'000 || !(scouts.patience > 0)) {
    return "scouts: count must be 0 … 10000, patience positive";
  }
  if (!(omission >= 0 && omission <= 1)) return "omission must be within 0 … 1";
  if (!(most_validated > 0)) return "most_validated must be above 0";
  if (!(fresh_seconds > 0)) return "fresh_seconds must be above 0";
  if (!(least_motion >= 0 && least_turn >= 0)) return "least_motion must not be negative";
  if (!(sharpness > 0 && sharpness <= 1e4)) return "sharpness must be within 0 … 10000";
  if (!(fresh > 0)) return "fresh must be positive";
  return std::nullopt;
}

}  // namespace infuse::streetmap
