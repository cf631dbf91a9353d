// Of the tracker: whether the pose may be used, why not, and what then.

#include <algorithm>
#include <cmath>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::streetmap {

void Tracker::update_state() {
  const ConfidenceOptions& confidence = options_.confidence;
  const PoseMoments moments = particles_.moments();
  const double spread = moments.spread(), p = significance_.p_value();
  const double yaw = std::sqrt(std::max(moments.covariance(2, 2), 0.0));
  const GnssWitness::Verdict gnss = gnss_.verdict();
  // LOST changes to TRACKING only.
  const auto set_state = [&](TrackState state, const char* reason) {
    const bool found = state_ != TrackState::kLost || state == TrackState::kTracking;
    state_ = found ? state : TrackState::kLost;
    reason_ = reason;
  };
  const bool enough_updates = updates_since_search_ >= confidence.window / 2;
  if (!map_.covers(moments.mean.x, moments.mean.y)) {
    set_state(TrackState::kLost, "the vehicle is outside the map");
    const auto place = gnss_.place({moments.mean.x, moments.mean.y});
    if (!place || !map_.covers(place->position.x(), place->position.y())) return;
  } else if (spread > confidence.min_lost_spread) {
    set_state(TrackState::kLost, "the particles are spread over too large an area");
  } else if (significance_.window_full() && p > confidence.min_lost_p_value) {
    set_state(TrackState::kLost, "sensor data match the map no better than by chance");
  } else if (gnss == GnssWitness::Verdict::kLost) {
    set_state(TrackState::kLost, "GNSS fixes contradict the pose on the map");
  } else if (gnss == GnssWitness::Verdict::kDoubt) {
    return set_state(TrackState::kUnsure, "GNSS fixes contradict the pose on the map");
  } else if (!enough_updates) {
    return set_state(TrackState::kUnsure, state_ == TrackState::kLost
                                              ? "searching for the position on the map"
                                              : "too few updates since the start");
  } else if (particles_.second_mode_weight() > confidence.max_tracking_second_mode_weight) {
    return set_state(TrackState::kUnsure, "two places on the map match the sensor data");
  } else if (spread > confidence.max_tracking_spread || yaw > confidence.max_tracking_yaw_sigma) {
    return set_state(TrackState::kUnsure, "the particles do not agree");
  } else if (p > confidence.max_tracking_p_value) {
    return set_state(TrackState::kUnsure, "sensor data match the map poorly");
  } else if (place_check_.running()) {
    return set_state(TrackState::kUnsure, place_check_.reason());
  } else if (state_ != TrackState::kTracking && fits_another_street(moments.mean)) {
    return set_state(TrackState::kUnsure, "another street fits the drive better");
  } else {
    return set_state(TrackState::kTracking, "");
  }
  // Lost: search again around the estimate once the last search had a full window of updates.
  if (gnss != GnssWitness::Verdict::kLost && updates_since_search_ < confidence.window) return;
  search_again(moments.mean);
}

// Searches around the estimate, and around the place that GNSS proposes if that is elsewhere. The
// map decides between the two.
void Tracker::search_again(const PlanarPose& estimate) {
  const ConfidenceOptions& confidence = options_.confidence;
  const bool contradicted = gnss_.verdict() == GnssWitness::Verdict::kLost;
  const auto place = gnss_.place({estimate.x, estimate.y});
  const char* lost_reason = reason_;
  gnss_.restart(contradicted);
  if (place) {
    const PlanarPose proposed{place->position.x(), place->position.y(),
                              place->yaw.value_or(estimate.yaw)};
    const double distance =
        geometry::plane_length(proposed.x - estimate.x, proposed.y - estimate.y);
    const double yaw_variance = confidence.search_yaw * confidence.search_yaw / 4;
    if (!map_.covers(estimate.x, estimate.y)) {
      search(proposed, 2 * place->sigma, confidence.search_yaw);
    } else {
      search(estimate, confidence.search_radius, confidence.search_yaw);
      if (distance > confidence.search_radius) {
        const double variance = place->sigma * place->sigma;
        particles_.add_mode(proposed,
                            Eigen::Vector3d(variance, variance, yaw_variance).asDiagonal());
      }
    }
  } else {
    search(estimate, confidence.search_radius, confidence.search_yaw);
  }
  reason_ = lost_reason;
}

}  // namespace infuse::streetmap
