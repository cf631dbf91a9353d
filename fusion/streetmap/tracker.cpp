#include "fusion/streetmap/tracker.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr double kOutside = -1e3;  // log-weight of a particle beyond the map
constexpr size_t kFewestSamples = 100;
constexpr double kViewYaw = 0.03;     // rad, how well one view tells the heading
constexpr double kWidestSpread = 20;  // m, of particles that all see the map

}  // namespace

const char* name(TrackState state) {
  switch (state) {
    case TrackState::kUnsure:
      return "UNSURE";
    case TrackState::kTracking:
      return "TRACKING";
    case TrackState::kLost:
      return "LOST";
  }
  return "LOST";
}

Eigen::Isometry3d TrackerEstimate::T_map_vehicle() const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() << pose.x, pose.y, 0;
  return T;
}

geometry::Matrix6 TrackerEstimate::covariance6() const {
  // Ours is of the pose's own x, y, yaw; a left perturbation turns the pose about the map's origin:
  // t' = t + dt + rz × t, so that dt = d(x, y) − rz × (x, y).
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J(0, 2) = pose.y;
  J(1, 2) = -pose.x;
  const Eigen::Matrix3d planar = J * covariance * J.transpose();
  constexpr int kOrder[3] = {3, 4, 2};  // x, y, yaw among (rx, ry, rz, tx, ty, tz)
  geometry::Matrix6 result = geometry::Matrix6::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result(kOrder[i], kOrder[k]) = planar(i, k);
  }
  result(0, 0) = result(1, 1) = 0.05 * 0.05;
  result(5, 5) = 1;
  return result;
}

Tracker::Tracker(const SegmentMap& map, const TrackerOptions& options)
    : map_(map),
      options_(options),
      grid_(options.grid),
      view_(options.measure, options.fit),
      particles_(options.particles, options.seed),
      null_test_(options.confidence.window),
      scouts_(options.scouts, options.seed + 2),
      random_(options.seed + 1) {
  const auto samples = static_cast<size_t>(options.grid.most_samples);
  view_.reserve(options.grid.most_samples, kSegmentKinds);
  window_.reserve(map, reach(kWidestSpread), options.labelling);
  samples_.features.resize(options.grid.most_samples, kFeatures);
  samples_.x.reserve(samples);
  samples_.y.reserve(samples);
  labels_.reserve(samples);
  scores_.reserve(static_cast<size_t>(options.particles.most));
  null_.reserve(static_cast<size_t>(options.confidence.null_draws));
}

// Half the edge of what the particles, the displaced poses and the scouts see of the map.
double Tracker::reach(double spread) const {
  constexpr double kDisplaced = 15;  // m
  return options_.grid.extent * 0.75 + 3 * std::min(spread, kWidestSpread) + kDisplaced;
}

void Tracker::start(const PlanarPose& pose, const Eigen::Matrix3d& covariance) {
  particles_.scatter(pose, covariance);
  null_test_.clear();
  scouts_.recall();
  common_.reset();
  started_ = true;
  state_ = TrackState::kUnsure;
  reason_ = "too few updates since the start";
  updates_since_search_ = 0;
}

void Tracker::search(const PlanarPose& pose, double radius, double yaw) {
  particles_.scatter_disc(pose, radius, yaw);
  null_test_.clear();
  scouts_.recall();
  started_ = true;
  state_ = TrackState::kLost;
  reason_ = "searching for its place on the map";
  updates_since_search_ = 0;
}

void Tracker::predict(const PlanarPose& motion, const Eigen::Matrix3d& covariance, Duration step) {
  odometry_ = odometry_.then(motion);
  driven_s_ += to_seconds(step);
  forgotten_place_ += covariance(0, 0) + covariance(1, 1);
  forgotten_yaw_ += covariance(2, 2);
  if (!started_) return;
  particles_.move(motion, covariance, to_seconds(step));
  scouts_.move(motion);
}

void Tracker::take(const StraightView& straight, const PictureView* picture,
                   const PlanarPose& then) {
  grid_.add(straight, picture, odometry_.then(then));
}

void Tracker::update() {
  grid_.samples(odometry_, samples_);
  update(samples_);
}

void Tracker::update(const GridSamples& samples) {
  if (!started_ || samples.size() < kFewestSamples || !moved_on()) return;
  if (*view_.prepare(samples) != '\0') return;
  const PoseMoments before = particles_.moments();
  window_.read(map_, before.mean.x, before.mean.y, reach(before.spread()), options_.labelling);
  labels_.resize(samples.size());
  weigh(samples);
  test_against_chance(samples);
  particles_.resample_if_needed();
  look_elsewhere(samples);
  ++updates_since_search_;
  judge();
}

bool Tracker::moved_on() {
  const PlanarPose motion = updated_at_.motion_to(odometry_);
  if (updates_since_search_ > 0 && std::hypot(motion.x, motion.y) < options_.least_motion &&
      std::abs(motion.yaw) < options_.least_turn) {
    return false;
  }
  tell_news(std::hypot(motion.x, motion.y));
  updated_at_ = odometry_;
  driven_s_ = 0;
  forgotten_place_ = forgotten_yaw_ = 0;
  return true;
}

// How much of a view is evidence of its own. Where the map is wrong it is so for tens of metres,
// and the odometry ties one view to the next: what it forgot in between, by its drift or by its
// stated covariance, must be found anew. Particles that are spread wider than the map is wrong
// learn from views that share the map's error. What was forgotten counts among poses that are
// nearer to each other than what the odometry forgot while a view is new, and not between two
// places farther apart: the map is as wrong at either as it was before.
void Tracker::tell_news(double distance) {
  constexpr double kMostHaste = 4;
  const PoseMoments moments = particles_.moments();
  const double map_variance = options_.confidence.map_sigma * options_.confidence.map_sigma;
  const double place = moments.spread() * moments.spread();
  const double haste = std::clamp(place / map_variance, 1.0, kMostHaste);
  const double forgotten = forgotten_place_ / map_variance + forgotten_yaw_ / (kViewYaw * kViewYaw);
  const bool first = updates_since_search_ == 0;
  const double driven = haste * distance / options_.fresh + driven_s_ / options_.fresh_seconds;
  blurred_ = blurred_ * std::exp(-distance / options_.fresh) + forgotten_place_;
  place_news_ = first ? 1 : std::min(1.0, driven);
  news_ = first ? 1 : std::min(1.0, driven + forgotten);
}

double Tracker::score_of(const PlanarPose& pose, const GridSamples& samples,
                         const std::optional<dependence::HyperParameters>& kept,
                         dependence::HyperParameters* chosen) {
  window_.look_up(pose, samples.x, samples.y, labels_);
  return view_.ask(labels_, window_, kept, chosen);
}

// I 3.3.2: some particles, chosen at random, are cross-validated; the others keep what they have,
// or take what the last one chose. Their number is bounded: what one tells serves many.
void Tracker::weigh(const GridSamples& samples) {
  std::uniform_real_distribution<double> share(0, 1);
  const double validated =
      std::min(1 - options_.omission,
               options_.most_validated / static_cast<double>(particles_.all().size()));
  const std::span<Particle> all = particles_.all();
  scores_.assign(all.size(), 0);
  for (size_t i = 0; i < all.size(); ++i) {
    Particle& particle = all[i];
    const bool omitted = share(random_) >= validated;
    if (!map_.covers(particle.pose.x, particle.pose.y)) continue;
    if (omitted && common_) {
      if (!particle.kept) particle.kept = common_;
    } else {
      particle.kept.reset();
    }
    dependence::HyperParameters chosen;
    scores_[i] = score_of(particle.pose, samples, particle.kept, &chosen);
    if (chosen.sigma > 0) common_ = particle.kept = chosen;
  }
  particles_.learn(scores_, options_.sharpness * news_, options_.sharpness * place_news_,
                   std::max(options_.confidence.map_sigma, std::sqrt(blurred_)));
  for (Particle& particle : all) {
    if (!map_.covers(particle.pose.x, particle.pose.y)) particle.log_weight = kOutside;
  }
}

void Tracker::test_against_chance(const GridSamples& samples) {
  const PlanarPose pose = particles_.moments().mean;
  score_ = score_of(pose, samples, common_);
  std::uniform_real_distribution<double> share(0, 1);
  null_.clear();
  for (int i = 0; i < options_.confidence.null_draws; ++i) {
    const double turned = (share(random_) < 0.5 ? -1 : 1) * (0.35 + 2.4 * share(random_));
    const double direction = 2 * std::numbers::pi * share(random_);
    const double distance = 5 + 10 * share(random_);
    null_.push_back(score_of({pose.x + distance * std::cos(direction),
                              pose.y + distance * std::sin(direction), wrapped(pose.yaw + turned)},
                             samples, common_));
  }
  null_test_.add(score_, null_);
}

void Tracker::look_elsewhere(const GridSamples& samples) {
  const auto score = [&](const PlanarPose& pose) { return score_of(pose, samples, common_); };
  if (particles_.doubt() > 0) return scouts_.recall();
  const auto place = scouts_.update(particles_.moments().mean, score_, place_news_, score);
  if (!place) return;
  particles_.add_place(*place, Eigen::Vector3d(1, 1, 0.0016).asDiagonal());
}

void Tracker::judge() {
  const ConfidenceOptions& confidence = options_.confidence;
  const PoseMoments moments = particles_.moments();
  const double spread = moments.spread(), p = null_test_.p_value();
  const double yaw = std::sqrt(std::max(moments.covariance(2, 2), 0.0));
  // Once lost, it is until all that TRACKING asks for holds.
  const auto say = [&](TrackState state, const char* reason) {
    const bool found = state_ != TrackState::kLost || state == TrackState::kTracking;
    state_ = found ? state : TrackState::kLost;
    reason_ = reason;
  };
  if (!map_.covers(moments.mean.x, moments.mean.y)) {
    return say(TrackState::kLost, "the vehicle is outside the map");
  }
  const bool settled = updates_since_search_ >= confidence.window / 2;
  if (spread > confidence.lost_spread) {
    say(TrackState::kLost, "the particles are spread over too wide a place");
  } else if (null_test_.settled() && p > confidence.lost_p) {
    say(TrackState::kLost, "what is seen fits the map no better than by chance");
  } else if (!settled) {
    return say(TrackState::kUnsure, "too few updates since the start");
  } else if (particles_.doubt() > confidence.tracking_doubt) {
    return say(TrackState::kUnsure, "two places on the map fit what is seen");
  } else if (spread > confidence.tracking_spread || yaw > confidence.tracking_yaw) {
    return say(TrackState::kUnsure, "the particles do not agree");
  } else if (p > confidence.tracking_p) {
    return say(TrackState::kUnsure, "what is seen hardly fits the map");
  } else {
    return say(TrackState::kTracking, "");
  }
  // Lost: look for the place anew, around where it should be, once the last search had its chance.
  if (updates_since_search_ < confidence.window) return;
  const char* why = reason_;
  search(moments.mean, confidence.search_radius, confidence.search_yaw);
  reason_ = why;
}

TrackerEstimate Tracker::estimate() const {
  TrackerEstimate estimate;
  estimate.state = state_;
  estimate.reason = reason_;
  if (!started_) return estimate;
  const PoseMoments moments = particles_.moments();
  estimate.pose = moments.mean;
  estimate.covariance = moments.covariance;
  const double map_variance = options_.confidence.map_sigma * options_.confidence.map_sigma;
  estimate.covariance(0, 0) += map_variance;
  estimate.covariance(1, 1) += map_variance;
  estimate.score = score_;
  estimate.p_value = null_test_.p_value();
  estimate.excess = null_test_.excess();
  estimate.entropy = particles_.entropy();
  estimate.particles = static_cast<int>(particles_.all().size());
  return estimate;
}

}  // namespace infuse::streetmap
