// Of the tracker: the search of all streets, as a witness and as a start.

#include <algorithm>
#include <cmath>
#include <functional>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::streetmap {
namespace {

constexpr double kMaxSearched = 2000;      // m of streets that the search witnesses while TRACKING
constexpr double kMinWitnessSpeed = 1;     // m/s, slower, time brings no other view
constexpr double kMinJudged = 100;         // m driven until the search judges an estimate
constexpr double kMinContradiction = 2.3;  // log-odds of another street: by chance one in ten, …
constexpr double kMinProposed = 4.6;  // … that keeps it from TRACKING; one in a hundred, a mode
constexpr double kProposalRadius = 120;       // m, of streets that are proposed instead
constexpr double kMaxSquaredDistance = 13.8;  // 99.9 % of χ² with 2 degrees of freedom
constexpr double kFoundYawSigma = 0.03;       // rad, of streets on the map
constexpr PlanarPose kWitnessOffsets[] = {
    {0, 0, 0}, {0, 1.5, 0}, {0, -1.5, 0}, {2.5, 0, 0}, {-2.5, 0, 0}};  // m

}  // namespace

// Where the map gives the place, the search ends when both agree (`use_found_street`).
void Tracker::search_streets(const PlanarPose& motion, const Eigen::Matrix3d& covariance,
                             Duration step) {
  if (!global_start_) return;
  if (!searching_streets_) {
    if (state_ != TrackState::kLost && !place_check_.running()) return;
    begin_search();
  }
  const double driven = geometry::plane_length(motion.x, motion.y);
  searched_ += driven;
  witnessed_m_ += driven;
  if (driven > kMinWitnessSpeed * to_seconds(step)) witnessed_s_ += to_seconds(step);
  global_start_->move(motion, covariance, to_seconds(step));
}

void Tracker::begin_search() {
  if (!started_) {
    global_start_->restart();
    reason_ = "no initial pose, searching all streets";
  } else {
    const PoseMoments moments = particles_.moments();
    global_start_->restart(BelievedPlace{moments.mean, moments.covariance, region_searched_});
  }
  searching_streets_ = true;
  driven_at_fix_ = INFINITY;
  searched_ = 0;
}

// A region that windows do not cover, of a vehicle that drove on unseen: the streets in it are
// searched.
void Tracker::search_region() {
  if (!started_ || !was_confirmed_ || region_searched_) return;
  const PoseMoments moments = particles_.moments();
  if (moments.spread() <= kMaxSpread) return;
  region_searched_ = true;
  place_check_.start(moments.mean, map_);
  if (global_start_) begin_search();
}

// True if the place that was found is that of the estimate. Unless that is TRACKING, it must be
// where the search has it.
bool Tracker::agrees(const FoundPlace& found) const {
  const PoseMoments estimate = particles_.moments();
  if (!is_same_place(estimate.mean, found.pose, options_.global_start.same_place)) return false;
  const Eigen::Vector2d d(estimate.mean.x - found.pose.x, estimate.mean.y - found.pose.y);
  const Eigen::Matrix2d C = (estimate.covariance + found.covariance).topLeftCorner<2, 2>();
  return state_ == TrackState::kTracking || d.dot(C.inverse() * d) < kMaxSquaredDistance;
}

PossiblePlaces Tracker::possible_places() const {
  PossiblePlaces places;
  if (state_ == TrackState::kTracking) return places;
  if (const auto second = started_ ? particles_.second_moments() : std::nullopt) {
    const PoseMoments first = particles_.moments();
    const double probability = particles_.second_mode_weight();
    if (probability < PossiblePlaces::kMinProbability) return places;
    places.add({first.mean, first.covariance, 1 - probability});
    places.add({second->mean, second->covariance, probability});
  } else if (judges_streets()) {
    places = global_start_->possible_places();
  }
  return places;
}

void Tracker::use_found_street() {
  if (!searching_streets_) return;
  const bool tracking = state_ == TrackState::kTracking;
  if (tracking && searched_ > kMaxSearched) searching_streets_ = false;
  const auto found = global_start_->place();
  if (!found || !found->sure) return;
  if (started_ && agrees(*found)) {
    if (tracking) searching_streets_ = false;
    return;
  }
  // What was begun along this street is given time.
  const double distance = options_.global_start.same_place;
  if (started_ && updates_since_start_ < options_.confidence.window &&
      is_same_place(particles_.moments().mean, found->pose, distance)) {
    return;
  }
  const Eigen::Vector3d map_error(0, 0, kFoundYawSigma * kFoundYawSigma);
  start(found->pose, found->covariance + Eigen::Matrix3d(map_error.asDiagonal()));
}

// The search has driven far enough to contradict and to confirm.
bool Tracker::judges_streets() const {
  return searching_streets_ && global_start_->driven() >= kMinJudged;
}

// What was confirmed cannot be far from where odometry has it.
double Tracker::proposal_radius() const {
  return was_confirmed_ && !region_searched_ ? kProposalRadius : INFINITY;
}

// A street that explains the drive, and much better than the one at a pose.
bool Tracker::fits_another_street(const PlanarPose& pose) const {
  return judges_streets() && global_start_->better_near(pose, proposal_radius(), kMinContradiction,
                                                        options_.global_start.max_mean_misfit);
}

// The drive is at odds with a start that nothing confirmed.
bool Tracker::is_refuted_start(const PlanarPose& pose) const {
  return !was_confirmed_ && is_doubted() && judges_streets() &&
         global_start_->behind(pose) > kMinProposed;
}

// The search has heard nothing of the fixes yet where it began anew.
void Tracker::witness_streets_by_fix() {
  const bool anew = global_start_->driven() < driven_at_fix_;
  driven_at_fix_ = global_start_->driven();
  const double cell = map_.frame().cell_size;
  const double area = cell * map_.columns() * cell * map_.rows();
  const auto evidence = [&](const PlanarPose& pose) {
    return gnss_.log_likelihood_in(area, {pose.x, pose.y}, anew);
  };
  global_start_->weigh(std::cref(evidence));
}

bool Tracker::begin_witness() {
  return searching_streets_ && global_start_->hypotheses() > 0 &&
         global_start_->hypotheses() <= options_.global_start.max_witnessed &&
         witnessed_m_ >= options_.min_motion;
}

// The poses of hypotheses are known to some metres: the best one nearby counts, for all alike.
void Tracker::witness_streets(const GridSamples& samples) {
  const double novelty = std::min(
      1.0, witnessed_m_ / options_.novelty_distance + witnessed_s_ / options_.novelty_seconds);
  witnessed_m_ = witnessed_s_ = 0;
  std::optional<dependence::HyperParameters> fixed;
  const auto evidence = [&](const PlanarPose& pose) {
    window_.read(map_, pose.x, pose.y, window_radius(0), options_.labelling);
    double best = 0;
    for (const PlanarPose& offset : kWitnessOffsets) {
      dependence::HyperParameters chosen;
      best = std::max(best, evaluate(window_, pose.compose(offset), samples, fixed, &chosen));
      if (!fixed && chosen.sigma > 0) fixed = chosen;
    }
    return options_.sharpness * novelty * best;
  };
  global_start_->weigh(std::cref(evidence));
}

// A street that explains the drive better than the one at the estimate becomes a mode, and what the
// sensors see decides. A doubted start may be anywhere, and beside the streets for a part of the
// drive; what was confirmed, beside the streets itself. True if there was one.
bool Tracker::propose_street(const PlanarPose& pose) {
  if (!judges_streets() || updates_since_proposal_ < options_.confidence.window / 2) return false;
  const bool anywhere = !was_confirmed_ && (is_doubted() || state_ == TrackState::kLost);
  const auto street =
      global_start_->better_near(pose, anywhere ? INFINITY : proposal_radius(), kMinProposed,
                                 anywhere ? INFINITY : options_.global_start.max_mean_misfit);
  if (!street) return false;
  updates_since_proposal_ = 0;
  particles_.add_mode(street->pose, street->covariance.topLeftCorner<3, 3>());
  return true;
}

}  // namespace infuse::streetmap
