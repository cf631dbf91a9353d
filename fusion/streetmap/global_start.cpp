#include "fusion/streetmap/global_start.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "fusion/geometry/plane_length.hpp"

namespace infuse::streetmap {
namespace {

constexpr int kDirections = 16;          // within half a turn (decision 17)
constexpr double kStartReach = 12;       // m, of free street ahead and behind (decision 17)
constexpr double kMinFreeLength = 14;    // m, ahead and behind together (decision 17)
constexpr double kStartYawSigma = 0.12;  // rad (decision 17)
constexpr double kMergeDistance = 2;     // m, edge of bins in which they are one (decision 17)
constexpr double kMergeYaw = 0.1;        // rad (decision 17)
constexpr double kMergeEvery = 10;       // m driven (decision 17)
constexpr double kStepYaw = 0.3;         // rad turned between two comparisons (decision 17)
constexpr double kStandingSpeed = 0.1;   // m/s (decision 17)
constexpr double kNoStreet = 0.2;        // mean misfit above which no street fits (decision 17)
constexpr double kMinDriven = 200;       // m, before that is judged (decision 17)
constexpr double kSameYaw = 0.5;         // rad, of hypotheses that are one place (decision 17)
constexpr double kMinTurn = 0.1;         // rad between two merges, which is not noise

using Vector5 = Eigen::Matrix<double, 5, 1>;

double log_add(double a, double b) {
  const double high = std::max(a, b);
  return high + std::log1p(std::exp(std::min(a, b) - high));
}

/// Free street ahead and behind, along each direction of half a turn.
std::array<double, kDirections> free_lengths(const StreetGrid& grid, const Eigen::Vector2d& p) {
  std::array<double, kDirections> lengths{};
  for (int i = 0; i < kDirections; ++i) {
    const double yaw = i * std::numbers::pi / kDirections;
    lengths[static_cast<size_t>(i)] =
        grid.free_length({p.x(), p.y(), yaw}, kStartReach) +
        grid.free_length({p.x(), p.y(), yaw + std::numbers::pi}, kStartReach);
  }
  return lengths;
}

uint64_t bin_of(const StreetHypothesis& hypothesis) {
  constexpr double kOffset = 1 << 20, kLevels = 128;  // bits of x, y, yaw
  const PlanarPose& pose = hypothesis.pose;
  const auto part = [](double value) { return static_cast<uint64_t>(value + kOffset); };
  return part(std::floor(pose.x / kMergeDistance)) << 42 |
         part(std::floor(pose.y / kMergeDistance)) << 21 |
         part(std::floor(wrap_angle(pose.yaw) / kMergeYaw) + kLevels * hypothesis.level);
}

}  // namespace

std::optional<std::string> GlobalStartOptions::invalid() const {
  if (!(spacing >= 1 && spacing <= 20 && step > 0.1 && step <= 10 && independent_length >= step)) {
    return "global_start: spacing must be between 1 and 20 m, step at most 10 m and the "
           "independent length";
  }
  if (max_hypotheses < 1000 || max_hypotheses > 1000000) {
    return "global_start: max_hypotheses must be between 1000 and 1000000";
  }
  if (!(street_sigma > 0 && max_misfit > 0 && max_log_odds > 0 && max_sigma > 0)) {
    return "global_start: sigmas and limits must be positive";
  }
  if (!(believed_radius >= 0 && believed_log_odds >= 0 && believed_log_odds < max_log_odds)) {
    return "global_start: believed_radius must be at least 0, believed_log_odds between 0 and "
           "max_log_odds";
  }
  if (!(max_elsewhere > 0 && max_elsewhere < 1 && max_mean_misfit > 0 && min_alone >= 0)) {
    return "global_start: max_elsewhere must be between 0 and 1, max_mean_misfit be positive";
  }
  if (!(turn_worth >= 0 && turn_worth <= 1000) || max_witnessed < 0 || max_witnessed > 1000) {
    return "global_start: turn_worth and max_witnessed must be between 0 and 1000";
  }
  return std::nullopt;
}

bool PossiblePlaces::add(const PossiblePlace& place) {
  if (count_ == kMaxCount) return false;
  places_[count_++] = place;
  return true;
}

bool is_same_place(const PlanarPose& a, const PlanarPose& b, double distance) {
  return geometry::plane_length(a.x - b.x, a.y - b.y) <= distance &&
         std::abs(wrap_angle(a.yaw - b.yaw)) <= kSameYaw;
}

void predict(StreetHypothesis& hypothesis, const PlanarPose& motion,
             const Eigen::Matrix3d& covariance, double seconds) {
  PlanarPose& pose = hypothesis.pose;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(pose.yaw).toRotationMatrix();
  const Eigen::Vector2d measured = R.topLeftCorner<2, 2>() * Eigen::Vector2d(motion.x, motion.y);
  const Eigen::Vector2d moved = hypothesis.scale * measured;
  StreetHypothesis::Matrix F = StreetHypothesis::Matrix::Identity();
  F(0, 2) = -moved.y();
  F(1, 2) = moved.x();
  F(0, 3) = measured.x();
  F(1, 3) = measured.y();
  F(2, 4) = seconds;
  pose.x += moved.x();
  pose.y += moved.y();
  pose.yaw = wrap_angle(pose.yaw + motion.yaw + hypothesis.yaw_rate_bias * seconds);
  hypothesis.covariance = F * hypothesis.covariance * F.transpose();
  hypothesis.covariance.topLeftCorner<3, 3>() += R * covariance * R.transpose();
}

void compare(StreetHypothesis& hypothesis, const StreetGrid& grid, double novelty,
             const GlobalStartOptions& options) {
  PlanarPose& pose = hypothesis.pose;
  const auto street = grid.across(pose, hypothesis.level);
  if (!street) {
    hypothesis.log_weight -= novelty * options.max_misfit;
    hypothesis.misfit += novelty * options.max_misfit;
    return;
  }
  Vector5 h = Vector5::Zero();  // the position across the heading, by the state
  h[0] = -std::sin(pose.yaw);
  h[1] = std::cos(pose.yaw);
  const Vector5 Ph = hypothesis.covariance * h;
  const double variance = h.dot(Ph), edge = options.street_sigma * options.street_sigma;
  // A position on the street is uniform across it. Its variance is that of independent evidence.
  const double width = street->half_width();
  const double noise = (width * width / 3 + edge) / novelty;
  const double innovation = street->centre(), outside = street->distance();
  hypothesis.misfit +=
      novelty * std::min(options.max_misfit, outside * outside / (edge + variance));
  hypothesis.log_weight -=
      std::min(novelty * options.max_misfit, innovation * innovation / (2 * (variance + noise)));
  const Vector5 gain = Ph / (variance + noise);
  const Vector5 change = gain * innovation;
  pose.x += change[0];
  pose.y += change[1];
  pose.yaw = wrap_angle(pose.yaw + change[2]);
  hypothesis.scale += change[3];
  hypothesis.yaw_rate_bias += change[4];
  hypothesis.covariance -= gain * Ph.transpose();
}

GlobalStart::GlobalStart(const SegmentMap& map, const GlobalStartOptions& options)
    : options_(options), grid_(map) {
  hypotheses_.reserve(static_cast<size_t>(options.max_hypotheses));
  bins_.reserve(static_cast<size_t>(options.max_hypotheses));
}

void GlobalStart::restart(const std::optional<BelievedPlace>& believed) {
  collected_ = compared_ = {};
  since_merge_ = driven_ = 0;
  count_alone(false);
  const auto capacity = static_cast<size_t>(options_.max_hypotheses);
  for (double spacing = options_.spacing;; spacing *= 1.25) {
    spread(spacing);
    if (hypotheses_.size() < capacity) break;
  }
  next_ = hypotheses_.size();
  if (!believed) return;
  if (believed->confirmed) return weigh_region(*believed);
  for (StreetHypothesis& hypothesis : hypotheses_) {
    const double distance = geometry::plane_length(hypothesis.pose.x - believed->pose.x,
                                                   hypothesis.pose.y - believed->pose.y);
    if (distance < options_.believed_radius) hypothesis.log_weight = options_.believed_log_odds;
  }
}

// The mixture of the region's normal distribution and of all streets alike.
void GlobalStart::weigh_region(const BelievedPlace& believed) {
  double sum = 0;
  for (StreetHypothesis& hypothesis : hypotheses_) {
    const Eigen::Vector3d d(hypothesis.pose.x - believed.pose.x,
                            hypothesis.pose.y - believed.pose.y,
                            wrap_angle(hypothesis.pose.yaw - believed.pose.yaw));
    const Eigen::Matrix3d C = believed.covariance + hypothesis.covariance.topLeftCorner<3, 3>();
    hypothesis.log_weight = -d.dot(C.inverse() * d) / 2;
    sum += std::exp(hypothesis.log_weight);
  }
  const double elsewhere = options_.max_elsewhere / (1 - options_.max_elsewhere) *
                           std::max(sum, std::numeric_limits<double>::min()) /
                           static_cast<double>(std::max<size_t>(hypotheses_.size(), 1));
  for (StreetHypothesis& hypothesis : hypotheses_) {
    hypothesis.log_weight = log_add(hypothesis.log_weight, std::log(elsewhere));
  }
}

// Stops when `max_hypotheses` are reached.
void GlobalStart::spread(double spacing) {
  hypotheses_.clear();
  const int every = std::max(static_cast<int>(spacing / StreetGrid::kCell), 1);
  const auto capacity = static_cast<size_t>(options_.max_hypotheses);
  for (int row = every / 2; row < grid_.rows(); row += every) {
    for (int column = every / 2; column < grid_.columns(); column += every) {
      const Eigen::Vector2d p = grid_.middle(column, row);
      if (!grid_.street(p.x(), p.y())) continue;
      const auto lengths = free_lengths(grid_, p);
      for (size_t i = 0; i < kDirections; ++i) {
        const double before = lengths[(i + kDirections - 1) % kDirections];
        const double after = lengths[(i + 1) % kDirections];
        if (lengths[i] < kMinFreeLength || lengths[i] < before || lengths[i] <= after) continue;
        for (const double reversed : {0.0, std::numbers::pi}) {
          if (hypotheses_.size() >= capacity) return;
          StreetHypothesis hypothesis;
          hypothesis.pose = {
              p.x(), p.y(),
              wrap_angle(static_cast<double>(i) * std::numbers::pi / kDirections + reversed)};
          const double place = spacing * spacing / 2, yaw = kStartYawSigma * kStartYawSigma;
          hypothesis.covariance.diagonal() << place, place, yaw,
              options_.scale_sigma * options_.scale_sigma,
              options_.yaw_rate_sigma * options_.yaw_rate_sigma;
          hypotheses_.push_back(hypothesis);
        }
      }
    }
  }
}

void GlobalStart::move(const PlanarPose& motion, const Eigen::Matrix3d& covariance,
                       double seconds) {
  const double distance = geometry::plane_length(motion.x, motion.y);
  collected_.motion = collected_.motion.compose(motion);
  driven_ += distance;
  if (distance <= kStandingSpeed * seconds) return;  // lasting errors turn nothing that stands
  collected_.covariance += covariance;
  collected_.covariance(2, 2) += options_.yaw_noise * options_.yaw_noise * distance;
  collected_.seconds += seconds;
  collected_.length += distance;
  if (next_ >= hypotheses_.size() &&
      (collected_.length >= options_.step || std::abs(collected_.motion.yaw) > kStepYaw)) {
    begin_comparison();
  }
  go_on_comparing();
}

void GlobalStart::begin_comparison() {
  compared_ = collected_;
  collected_ = {};
  since_merge_ += compared_.length;
  turned_ += compared_.motion.yaw;
  if (since_merge_ >= kMergeEvery) {
    drop_and_merge();
    const auto found = find();
    if (found && driven_ > kMinDriven && found->misfit > kNoStreet) return restart();
    count_alone(found && found->elsewhere < options_.max_elsewhere);
    since_merge_ = 0;
  }
  next_ = 0;
}

// A turn is worth something once the streets of it lie behind, so that they can have refuted it.
void GlobalStart::count_alone(bool alone) {
  alone_ = alone ? alone_ + since_merge_ + options_.turn_worth * turns_.front() : 0;
  std::shift_left(turns_.begin(), turns_.end(), 1);
  turns_.back() = std::abs(turned_) > kMinTurn ? std::abs(turned_) : 0;
  if (!alone) turns_.fill(0);
  turned_ = 0;
}

void GlobalStart::go_on_comparing() {
  const double novelty = std::min(compared_.length / options_.independent_length, 1.0);
  const size_t end =
      std::min(next_ + static_cast<size_t>(options_.max_compared), hypotheses_.size());
  for (; next_ < end; ++next_) {
    StreetHypothesis& hypothesis = hypotheses_[next_];
    const Eigen::Vector2d before(hypothesis.pose.x, hypothesis.pose.y);
    predict(hypothesis, compared_.motion, compared_.covariance, compared_.seconds);
    hypothesis.level =
        grid_.level_after(hypothesis.level, before, {hypothesis.pose.x, hypothesis.pose.y});
    compare(hypothesis, grid_, novelty, options_);
  }
}

// Pose of a hypothesis with the motion that it has not been compared after.
PlanarPose GlobalStart::now(size_t hypothesis) const {
  const PlanarPose& pose = hypotheses_[hypothesis].pose;
  return (hypothesis < next_ ? pose : pose.compose(compared_.motion)).compose(collected_.motion);
}

void GlobalStart::weigh(const std::function<double(const PlanarPose&)>& evidence) {
  for (size_t i = 0; i < hypotheses_.size(); ++i) hypotheses_[i].log_weight += evidence(now(i));
}

void GlobalStart::drop_and_merge() {
  double best = -INFINITY;
  for (const StreetHypothesis& h : hypotheses_) best = std::max(best, h.log_weight);
  std::erase_if(hypotheses_, [&](const StreetHypothesis& h) {
    return !(h.log_weight > best - options_.max_log_odds);
  });
  bins_.clear();
  for (uint32_t i = 0; i < hypotheses_.size(); ++i) bins_.emplace_back(bin_of(hypotheses_[i]), i);
  std::sort(bins_.begin(), bins_.end());
  for (size_t i = 0, next = 0; i < bins_.size(); i = next) {
    StreetHypothesis* kept = &hypotheses_[bins_[i].second];
    double sum = kept->log_weight;
    for (next = i + 1; next < bins_.size() && bins_[next].first == bins_[i].first; ++next) {
      StreetHypothesis* other = &hypotheses_[bins_[next].second];
      sum = log_add(sum, other->log_weight);
      if (other->log_weight > kept->log_weight) std::swap(kept, other);
      other->log_weight = -INFINITY;
    }
    kept->log_weight = sum;
  }
  std::erase_if(hypotheses_, [](const StreetHypothesis& h) { return h.log_weight == -INFINITY; });
}

double GlobalStart::mean_misfit(const StreetHypothesis& hypothesis) const {
  return hypothesis.misfit * options_.independent_length / std::max(driven_, 1.0);
}

// The hypotheses at the place of one, but for those at `others`.
GlobalStart::Cluster GlobalStart::cluster_about(size_t middle_index,
                                                std::span<const PossiblePlace> others) const {
  const double reference = hypotheses_[middle_index].log_weight;
  const PlanarPose middle = now(middle_index);
  Cluster cluster;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  // difference from the middle
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    const double weight = std::exp(hypotheses_[i].log_weight - reference);
    const PlanarPose pose = now(i);
    if (!is_same_place(pose, middle, options_.same_place) || is_among(others, pose)) {
      cluster.elsewhere += weight;
      continue;
    }
    const Eigen::Vector3d d(pose.x - middle.x, pose.y - middle.y,
                            wrap_angle(pose.yaw - middle.yaw));
    cluster.here += weight;
    mean += weight * d;
    square += weight * (d * d.transpose() + hypotheses_[i].covariance.topLeftCorner<3, 3>());
  }
  mean /= cluster.here;
  cluster.pose = {middle.x + mean[0], middle.y + mean[1], wrap_angle(middle.yaw + mean[2])};
  cluster.covariance = square / cluster.here - mean * mean.transpose();
  const double edge = options_.street_sigma * options_.street_sigma;
  cluster.covariance.topLeftCorner<2, 2>() += edge * Eigen::Matrix2d::Identity();
  return cluster;
}

bool GlobalStart::is_among(std::span<const PossiblePlace> places, const PlanarPose& pose) const {
  return std::ranges::any_of(places, [&](const PossiblePlace& place) {
    return is_same_place(place.pose, pose, options_.same_place);
  });
}

// The likeliest hypothesis that is not at `others`.
std::optional<size_t> GlobalStart::likeliest(std::span<const PossiblePlace> others) const {
  std::optional<size_t> best;
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    if (best && hypotheses_[i].log_weight <= hypotheses_[*best].log_weight) continue;
    if (!is_among(others, now(i))) best = i;
  }
  return best;
}

std::optional<FoundPlace> GlobalStart::find() const {
  const auto best = likeliest({});
  if (!best) return std::nullopt;
  const Cluster cluster = cluster_about(*best, {});
  FoundPlace found;
  found.pose = cluster.pose;
  found.covariance = cluster.covariance;
  found.misfit = mean_misfit(hypotheses_[*best]);
  found.elsewhere = cluster.elsewhere / (cluster.here + cluster.elsewhere);
  found.alone = alone_;
  return found;
}

PossiblePlaces GlobalStart::possible_places() const {
  PossiblePlaces places;
  while (const auto next = likeliest(places.all())) {
    const Cluster cluster = cluster_about(*next, places.all());
    const double probability = cluster.here / (cluster.here + cluster.elsewhere);
    if (probability < PossiblePlaces::kMinProbability) break;
    if (!places.add({cluster.pose, cluster.covariance, probability})) break;
  }
  return places;
}

// Half of the squared distance of a pose from a hypothesis that is at `at`, in units of its
// variance: what its density is less there.
double GlobalStart::half_squared_distance(const StreetHypothesis& hypothesis, const PlanarPose& at,
                                          const PlanarPose& pose) const {
  const Eigen::Vector2d d(at.x - pose.x, at.y - pose.y);
  const double edge = options_.street_sigma * options_.street_sigma;
  const Eigen::Matrix2d C =
      hypothesis.covariance.topLeftCorner<2, 2>() + edge * Eigen::Matrix2d::Identity();
  return d.dot(C.inverse() * d) / 2;
}

double GlobalStart::behind(const PlanarPose& pose) const {
  double best = -INFINITY, there = -INFINITY;
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    best = std::max(best, hypotheses_[i].log_weight);
    if (!is_same_place(now(i), pose, options_.same_place)) continue;
    there = std::max(there, hypotheses_[i].log_weight);
  }
  return best - there;
}

std::optional<StreetHypothesis> GlobalStart::better_near(const PlanarPose& pose, double radius,
                                                         double log_odds, double max_misfit) const {
  std::optional<StreetHypothesis> best;
  double there = -INFINITY;
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    const StreetHypothesis& hypothesis = hypotheses_[i];
    const PlanarPose at = now(i);
    if (geometry::plane_length(at.x - pose.x, at.y - pose.y) > radius) continue;
    if (is_same_place(at, pose, options_.same_place)) {
      there = std::max(there, hypothesis.log_weight - half_squared_distance(hypothesis, at, pose));
    }
    if (mean_misfit(hypothesis) >= max_misfit) continue;
    if (best && hypothesis.log_weight <= best->log_weight) continue;
    best = hypothesis;
    best->pose = at;
  }
  if (best && best->log_weight - there <= log_odds) return std::nullopt;
  return best;
}

std::optional<FoundPlace> GlobalStart::place() const {
  auto found = find();
  if (!found) return found;
  const double sigma = std::sqrt(found->covariance.topLeftCorner<2, 2>().trace());
  found->sure = alone_ >= options_.min_alone && found->elsewhere < options_.max_elsewhere &&
                found->misfit < options_.max_mean_misfit && sigma < options_.max_sigma;
  return found;
}

}  // namespace infuse::streetmap
