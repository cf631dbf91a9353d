#include "fusion/streetmap/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/streetmap/drive_odds.hpp"

namespace infuse::streetmap {
namespace {

constexpr size_t kMinSamples = 100;
constexpr double kViewYawSigma = 0.03;  // rad, heading accuracy of one view
constexpr double kMinJump = 3;          // m of the estimate in one update: another place

/// Half the edge of the map window that the other places of `PlaceCheck` need.
double wide_window_radius(const TrackerOptions& options) {
  const PlaceCheckOptions& test = options.place_check;
  return options.grid.extent * 0.75 +
         std::max({test.max_along, test.max_across, std::numbers::sqrt2 * test.max_distance});
}

}  // namespace

Tracker::Tracker(const SegmentMap& map, const TrackerOptions& options,
                 std::unique_ptr<ViewScore> score)
    : map_(map),
      options_(options),
      grid_(options.grid),
      view_(score ? std::move(score) : std::make_unique<LsmiScore>(options.fit)),
      particles_(options.particles, options.seed),
      significance_(options.confidence.window),
      standing_significance_(options.confidence.window),
      global_search_(options.global_search, options.place_check, options.seed + 2),
      place_check_(options.place_check, options.seed + 3),
      gnss_(options.gnss),
      random_(options.seed + 1) {
  if (options.global_start.enabled) global_start_.emplace(map, options.global_start);
  if (global_start_ && !global_start_->possible()) {
    global_start_.reset();
    reason_ =
        "no initial pose, and the map has no streets, or more than 1000 km²: cut it with infuse "
        "streetmap --clip";
  }
  const auto samples = static_cast<size_t>(options.grid.max_samples);
  view_->reserve(options.grid.max_samples, kSegmentKindCount);
  for (LabelWindow* window : {&window_, &second_window_}) {
    window->reserve(map, window_radius(kMaxSpread), options.labelling);
  }
  wide_window_.reserve(map, wide_window_radius(options), options.labelling);
  samples_.features.resize(options.grid.max_samples, kFeatureCount);
  samples_.x.reserve(samples);
  samples_.y.reserve(samples);
  labels_.reserve(samples);
  scores_.reserve(static_cast<size_t>(options.particles.max_count));
  null_scores_.reserve(static_cast<size_t>(options.confidence.null_draws));
}

// Half the edge of the map window that particles, displaced poses and search candidates need.
double Tracker::window_radius(double spread) const {
  constexpr double kMaxDisplacement = 15;  // m
  return options_.grid.extent * 0.75 + 3 * std::min(spread, kMaxSpread) + kMaxDisplacement;
}

// Two modes may be further from each other than a window reaches.
void Tracker::read_windows(const PoseMoments& likelier) {
  const auto read = [&](LabelWindow& window, const PoseMoments& moments) {
    window.read(map_, moments.mean.x, moments.mean.y, window_radius(moments.spread()),
                options_.labelling);
    return moments.mean;
  };
  window_middle_ = read(window_, likelier);
  second_middle_.reset();
  if (const auto second = particles_.second_moments()) {
    second_middle_ = read(second_window_, *second);
  }
}

const LabelWindow& Tracker::window_at(const PlanarPose& pose) const {
  const auto distance = [&](const PlanarPose& middle) {
    return geometry::plane_length(middle.x - pose.x, middle.y - pose.y);
  };
  const bool second = second_middle_ && distance(*second_middle_) < distance(window_middle_);
  return second ? second_window_ : window_;
}

void Tracker::start(const PlanarPose& pose, const Eigen::Matrix3d& covariance) {
  particles_.scatter(pose, covariance);
  significance_.clear();
  global_search_.reset();
  last_hyper_parameters_.reset();
  place_check_.start(pose, map_);
  gnss_.restart(false);
  started_ = true;
  was_confirmed_ = region_searched_ = false;
  state_ = TrackState::kUnsure;
  reason_ = "too few updates since the start";
  updates_since_start_ = 0;
}

void Tracker::predict(const PlanarPose& motion, const Eigen::Matrix3d& covariance, Duration step) {
  odometry_ = odometry_.compose(motion);
  driven_s_ += to_seconds(step);
  odometry_position_variance_ += covariance(0, 0) + covariance(1, 1);
  odometry_yaw_variance_ += covariance(2, 2);
  gnss_.advance(to_seconds(step));
  search_streets(motion, covariance, step);
  if (!started_) return;
  particles_.predict(motion, covariance, to_seconds(step));
  if (state_ == TrackState::kTracking && !particles_agree(particles_.moments())) {
    state_ = TrackState::kUnsure;
    reason_ = kDisagreement;
  }
}

void Tracker::add_sweep(const DeskewedView& deskewed, const ImageView* image,
                        const PlanarPose& sensor_pose) {
  grid_.add(deskewed, image, odometry_.compose(sensor_pose));
}

void Tracker::update() {
  grid_.draw_samples(odometry_, samples_);
  update(samples_);
}

void Tracker::update(const GridSamples& samples) {
  use_found_street();
  if (samples.size() < kMinSamples) return;
  search_region();
  const bool witnesses = begin_witness(), updates = started_ && begin_update();
  if ((!witnesses && !started_) || *view_->prepare(samples) != '\0') return;
  labels_.resize(samples.size());
  if (witnesses) witness_streets(samples);
  if (started_ && !updates) judge_standing(samples);
  if (!updates) return;
  standing_significance_.clear();
  z_when_it_stopped_.reset();
  const PoseMoments before = particles_.moments();
  read_windows(before);
  update_weights(samples);
  add_score(samples, significance_);
  particles_.resample_if_needed();
  search_globally(samples);
  check_place(samples, before.mean);
  ++updates_since_start_;
  ++updates_since_proposal_;
  if (gnss_.verdict() != GnssWitness::Verdict::kNone) propose_fix(particles_.moments().mean);
  update_state();
}

void Tracker::add_fix(const MapFix& fix) {
  const PoseMoments moments = started_ ? particles_.moments() : PoseMoments();
  const double spread = moments.spread();
  if (started_) {
    gnss_.add(fix, {moments.mean.x, moments.mean.y}, spread * spread);
  } else {
    gnss_.add(fix);
  }
  if (searching_streets_) witness_streets_by_fix();
  if (!started_) return;
  for (Particle& particle : particles_.all()) {
    particle.log_weight += gnss_.log_likelihood({particle.pose.x, particle.pose.y});
  }
  update_state();
}

bool Tracker::begin_update() {
  const PlanarPose motion = odometry_at_update_.motion_to(odometry_);
  if (updates_since_start_ > 0 &&
      geometry::plane_length(motion.x, motion.y) < options_.min_motion &&
      std::abs(motion.yaw) < options_.min_rotation) {
    return false;
  }
  update_novelty(geometry::plane_length(motion.x, motion.y));
  odometry_at_update_ = odometry_;
  driven_s_ = 0;
  odometry_position_variance_ = odometry_yaw_variance_ = 0;
  return true;
}

// Share of a view that is independent evidence. A map error extends over tens of metres, and the
// odometry correlates successive views; the position that the odometry lost by drift or by its
// stated covariance must be estimated again. Particles that are spread wider than the map error
// gain from views that share that error. Odometry loss counts among poses closer to each other than
// that loss, not between two distant modes: the map error is the same at either as before.
void Tracker::update_novelty(double distance) {
  constexpr double kMaxSpeedup = 4;
  const PoseMoments moments = particles_.moments();
  const double map_variance = options_.confidence.map_sigma * options_.confidence.map_sigma;
  const double place = moments.spread() * moments.spread();
  const double speedup = std::clamp(place / map_variance, 1.0, kMaxSpeedup);
  const double odometry_novelty = odometry_position_variance_ / map_variance +
                                  odometry_yaw_variance_ / (kViewYawSigma * kViewYawSigma);
  const bool first = updates_since_start_ == 0;
  const double driving_novelty =
      speedup * distance / options_.novelty_distance + driven_s_ / options_.novelty_seconds;
  recent_position_variance_ =
      recent_position_variance_ * std::exp(-distance / options_.novelty_distance) +
      odometry_position_variance_;
  mode_novelty_ = first ? 1 : std::min(1.0, driving_novelty);
  novelty_ = first ? 1 : std::min(1.0, driving_novelty + odometry_novelty);
}

double Tracker::evaluate(const LabelWindow& window, const PlanarPose& pose,
                         const GridSamples& samples,
                         const std::optional<dependence::HyperParameters>& fixed,
                         dependence::HyperParameters* chosen) {
  window.look_up(pose, samples.x, samples.y, labels_);
  return view_->evaluate(labels_, window, fixed, chosen);
}

// I 3.3.2: a random subset of the particles is cross-validated; the others keep their
// hyper-parameters or use those last chosen. The size of the subset is bounded.
void Tracker::update_weights(const GridSamples& samples) {
  std::uniform_real_distribution<double> share(0, 1);
  const double validated =
      std::min(1 - options_.skipped_validation_share,
               options_.max_validated / static_cast<double>(particles_.all().size()));
  const std::span<Particle> all = particles_.all();
  scores_.assign(all.size(), 0);
  double covered_sum = 0;
  size_t covered = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    Particle& particle = all[i];
    const bool omitted = share(random_) >= validated;
    if (!map_.covers(particle.pose.x, particle.pose.y)) continue;
    ++covered;
    if (omitted && last_hyper_parameters_) {
      if (!particle.hyper_parameters) particle.hyper_parameters = last_hyper_parameters_;
    } else {
      particle.hyper_parameters.reset();
    }
    dependence::HyperParameters chosen;
    scores_[i] = evaluate(window_at(particle.pose), particle.pose, samples,
                          particle.hyper_parameters, &chosen);
    covered_sum += scores_[i];
    if (chosen.sigma > 0) last_hyper_parameters_ = particle.hyper_parameters = chosen;
  }
  // Outside the map there is no evidence: neither for a particle nor against it.
  for (size_t i = 0; covered > 0 && i < all.size(); ++i) {
    if (map_.covers(all[i].pose.x, all[i].pose.y)) continue;
    scores_[i] = covered_sum / static_cast<double>(covered);
  }
  particles_.update_weights(
      scores_, options_.sharpness * novelty_, options_.sharpness * mode_novelty_,
      std::max(options_.confidence.map_sigma, std::sqrt(recent_position_variance_)));
}

void Tracker::add_score(const GridSamples& samples, ScoreSignificance& significance) {
  const PlanarPose pose = particles_.moments().mean;
  if (!map_.covers(pose.x, pose.y)) return;
  const LabelWindow& window = window_at(pose);
  score_ = evaluate(window, pose, samples, last_hyper_parameters_);
  std::uniform_real_distribution<double> share(0, 1);
  null_scores_.clear();
  for (int i = 0; i < options_.confidence.null_draws; ++i) {
    const double side = share(random_) < 0.5 ? -1 : 1;
    const double turned = side * (0.35 + 2.4 * share(random_));
    const double direction = 2 * std::numbers::pi * share(random_);
    const double distance = 5 + 10 * share(random_);
    null_scores_.push_back(
        evaluate(window,
                 {pose.x + distance * std::cos(direction), pose.y + distance * std::sin(direction),
                  wrap_angle(pose.yaw + turned)},
                 samples, last_hyper_parameters_));
  }
  significance.add(score_, null_scores_);
}

// The place of a vehicle that is carried, or whose wheels and gyros lie, is to be confirmed anew. A
// z-score of n null scores has the variance 1/n + z²/2(n - 1) (Hedges 1981, of a standardised
// mean).
void Tracker::judge_standing(const GridSamples& samples) {
  constexpr double kSigmas = 3;  // 99.7 % of a Gaussian
  if (state_ != TrackState::kTracking) return;
  const PoseMoments moments = particles_.moments();
  read_windows(moments);
  add_score(samples, standing_significance_);
  if (!standing_significance_.window_full()) return;
  const double z = standing_significance_.mean_z_score();
  if (!z_when_it_stopped_) z_when_it_stopped_ = z;
  const double n = options_.confidence.null_draws, before = *z_when_it_stopped_;
  const double variance = 1 / n + before * before / (2 * std::max(n - 1, 1.0));
  if (before - z < kSigmas * std::sqrt(2 * variance / options_.confidence.window)) return;
  place_check_.start(moments.mean, map_);
  global_search_.reset();
  state_ = TrackState::kUnsure;
  reason_ = "the view changes although odometry says that the vehicle stands";
}

void Tracker::search_globally(const GridSamples& samples) {
  const auto score = [&](const PlanarPose& pose) {
    return evaluate(window_at(pose), pose, samples, last_hyper_parameters_);
  };
  const PoseMoments moments = particles_.moments();
  const bool scored = map_.covers(moments.mean.x, moments.mean.y);  // `score_` is of this view
  if (!scored || particles_.second_mode_weight() > 0) return global_search_.reset();
  const auto place =
      global_search_.update(moments.mean, position_covariance(moments), score_, mode_novelty_,
                            options_.sharpness * mode_novelty_, score);
  if (place) particles_.add_mode(*place, Eigen::Vector3d(1, 1, 0.0016).asDiagonal());
}

// An estimate that jumped is another place, whose evidence begins anew. So does that of one that
// the sensors confirm no more.
void Tracker::check_place(const GridSamples& samples, const PlanarPose& before) {
  const PoseMoments moments = particles_.moments();
  const PlanarPose& pose = moments.mean;
  const double jump = geometry::plane_length(pose.x - before.x, pose.y - before.y);
  if (jump > std::max(kMinJump, 3 * moments.spread())) {
    place_check_.start(pose, map_);
    global_search_.reset();
    gnss_.restart(false);
  }
  if (!place_check_.running() && is_doubted()) place_check_.start(pose, map_);
  if (!place_check_.running()) return;
  wide_window_.read(map_, pose.x, pose.y, wide_window_radius(options_), options_.labelling);
  const auto score = [&](const PlanarPose& place) {
    return evaluate(wide_window_, place, samples, last_hyper_parameters_);
  };
  std::optional<FoundPlace> found;
  if (judges_streets()) found = global_start_->place();
  const DriveOdds by_drive(found, options_.global_start, pose);
  const auto by_others = [&](const PlanarPose& place) {
    return by_drive(place) + gnss_.log_odds({place.x, place.y}, {pose.x, pose.y});
  };
  place_check_.update(pose, position_covariance(moments), options_.sharpness * mode_novelty_, score,
                      std::cref(by_others));
  const double second = particles_.second_mode_weight();
  if (second > (is_doubted() ? options_.confidence.max_tracking_second_mode_weight : 0)) return;
  if (propose_street(pose) || second > 0) return;
  if (const auto candidate = place_check_.propose()) {
    particles_.add_mode(*candidate, Eigen::Vector3d(1, 1, 0.0016).asDiagonal());
  }
}

}  // namespace infuse::streetmap
