// Of the tracker: whether the pose may be used, and why not.

#include <algorithm>
#include <cmath>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::streetmap {
namespace {

constexpr double kCourseSigma = 0.1;  // rad, of the course that a fix states
constexpr double kSamePlace = 3;      // sigmas of the place of fixes: 98.9 % of χ² with 2 degrees
constexpr double kHeadingSigma =
    0.5;  // rad, of the estimate's heading where fixes refute its place

}  // namespace

// The sensors match the map at the pose no better than elsewhere.
bool Tracker::is_doubted() const {
  return significance_.window_full() &&
         significance_.p_value() > options_.confidence.max_kept_p_value;
}

bool Tracker::particles_agree(const PoseMoments& moments) const {
  const ConfidenceOptions& confidence = options_.confidence;
  const double yaw = std::sqrt(std::max(moments.covariance(2, 2), 0.0));
  return moments.spread() <= confidence.max_tracking_spread &&
         yaw <= confidence.max_tracking_yaw_sigma;
}

void Tracker::update_state() {
  const ConfidenceOptions& confidence = options_.confidence;
  const PoseMoments moments = particles_.moments();
  const double p = significance_.p_value();
  const bool tracking = state_ == TrackState::kTracking;
  const GnssWitness::Verdict gnss = gnss_.verdict();
  // LOST changes to TRACKING only, and its reason stays.
  const auto set_state = [&](TrackState state, const char* reason) {
    if (state_ == TrackState::kLost && state == TrackState::kUnsure) return;
    state_ = state;
    reason_ = reason;
  };
  const auto unsure = [&](const char* reason) { set_state(TrackState::kUnsure, reason); };
  if (gnss == GnssWitness::Verdict::kLost) {
    set_state(TrackState::kLost, "GNSS fixes contradict the pose on the map");
    gnss_.restart(true);
    place_check_.start(moments.mean, map_);
    was_confirmed_ = false;
  } else if (!map_.covers(moments.mean.x, moments.mean.y)) {
    set_state(was_confirmed_ ? TrackState::kUnsure : TrackState::kLost,
              "the vehicle is outside the map");
  } else if (is_refuted_start(moments.mean)) {
    set_state(TrackState::kLost,
              "the drive and the sensors do not fit the map at the place where the drive began");
  } else if (gnss == GnssWitness::Verdict::kDoubt) {
    unsure("GNSS fixes contradict the pose on the map");
  } else if (updates_since_start_ < confidence.window / 2) {
    unsure("too few updates since the start");
  } else if (particles_.second_mode_weight() > confidence.max_tracking_second_mode_weight) {
    unsure("two places on the map match the sensor data");
  } else if (!particles_agree(moments)) {
    unsure(kDisagreement);
  } else if (is_doubted()) {
    unsure("sensor data match the map no better than by chance");
  } else if (!tracking && p > confidence.max_tracking_p_value) {
    unsure("sensor data match the map poorly");
  } else if (place_check_.running()) {
    unsure(place_check_.reason());
  } else if (!tracking && fits_another_street(moments.mean)) {
    unsure("another street fits the drive better");
  } else {
    was_confirmed_ = true;
    region_searched_ = false;
    set_state(TrackState::kTracking, "");
  }
}

// The place that GNSS proposes becomes a mode, and the map decides between the two. Outside the map
// there is nothing to decide.
void Tracker::propose_fix(const PlanarPose& estimate) {
  if (updates_since_proposal_ < options_.confidence.window / 2) return;
  const auto place = gnss_.place({estimate.x, estimate.y});
  if (!place || !map_.covers(place->position.x(), place->position.y())) return;
  const auto second = particles_.second_moments();
  if (second && (place->position - Eigen::Vector2d(second->mean.x, second->mean.y)).norm() <
                    kSamePlace * place->sigma) {
    return;
  }
  updates_since_proposal_ = 0;
  const PlanarPose proposed{place->position.x(), place->position.y(),
                            place->yaw.value_or(estimate.yaw)};
  const double variance = place->sigma * place->sigma;
  const double yaw_sigma = place->yaw ? kCourseSigma : kHeadingSigma;
  const Eigen::Vector3d variances(variance, variance, yaw_sigma * yaw_sigma);
  if (map_.covers(estimate.x, estimate.y)) {
    particles_.add_mode(proposed, variances.asDiagonal());
    return;
  }
  particles_.scatter(proposed, variances.asDiagonal());
  place_check_.start(proposed, map_);
  gnss_.restart(false);
}

}  // namespace infuse::streetmap
