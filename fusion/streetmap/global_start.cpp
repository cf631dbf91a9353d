#include "fusion/streetmap/global_start.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/streetmap/street_directions.hpp"

namespace infuse::streetmap {
namespace {

constexpr double kMergeDistance = 2;    // m, edge of bins in which they are one (decision 17)
constexpr double kMergeYaw = 0.1;       // rad (decision 17)
constexpr double kMergeEvery = 10;      // m driven (decision 17)
constexpr double kStepYaw = 0.3;        // rad turned between two comparisons (decision 17)
constexpr double kStandingSpeed = 0.1;  // m/s (decision 17)
constexpr double kNoStreet = 0.2;       // mean misfit above which no street fits (decision 17)
constexpr double kMinDriven = 200;      // m, before that is judged (decision 17)
constexpr double kSameYaw = 0.5;        // rad, of hypotheses that are one place (decision 17)
constexpr double kNearby = 1500;        // m around a believed place, of a large map; bounds time
constexpr double kMinTurn = 0.1;        // rad between two merges, which is not noise

double log_add(double a, double b) {
  const double high = std::max(a, b);
  return high + std::log1p(std::exp(std::min(a, b) - high));
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

bool PossiblePlaces::add(const PossiblePlace& place) {
  if (count_ == kMaxCount) return false;
  places_[count_++] = place;
  return true;
}

bool is_same_place(const PlanarPose& a, const PlanarPose& b, double distance) {
  return geometry::plane_length(a.x - b.x, a.y - b.y) <= distance &&
         std::abs(wrap_angle(a.yaw - b.yaw)) <= kSameYaw;
}

GlobalStart::GlobalStart(const SegmentMap& map, const GlobalStartOptions& options)
    : options_(options), grid_(map) {
  hypotheses_.reserve(static_cast<size_t>(options.max_hypotheses));
  bins_.reserve(static_cast<size_t>(options.max_hypotheses));
  spacing_ = spread_in(everywhere());
  if (spacing_) return;
  seeds_.emplace(options);
  pending_.reserve(StreetSeeds::kMaxTrack);
}

GlobalStart::Cells GlobalStart::everywhere() const { return {0, 0, grid_.columns(), grid_.rows()}; }

GlobalStart::Cells GlobalStart::near(const PlanarPose& pose, double reach) const {
  const Eigen::Vector2d corner = grid_.middle(0, 0);
  const auto cell = [](double metres) {
    return static_cast<int>(std::clamp(metres / StreetGrid::kCell, -1e6, 1e6));
  };
  return {std::max(cell(pose.x - corner.x() - reach), 0),
          std::max(cell(pose.y - corner.y() - reach), 0),
          std::min(cell(pose.x - corner.x() + reach), grid_.columns()),
          std::min(cell(pose.y - corner.y() + reach), grid_.rows())};
}

// Of the streets about a pose, as far as there is room for; false if there are none.
bool GlobalStart::spread_near(const PlanarPose& pose) {
  for (double reach = kNearby; reach > options_.same_place; reach /= 2) {
    if (spread_in(near(pose, reach))) return !hypotheses_.empty();
  }
  return false;
}

void GlobalStart::restart(const std::optional<BelievedPlace>& believed) {
  collected_ = compared_ = {};
  pending_.clear();
  since_merge_ = driven_ = 0;
  count_alone(false);
  seeding_ = false;
  if (spacing_) {
    spread(everywhere(), *spacing_);
  } else {
    seeding_ = !believed || !spread_near(believed->pose);
  }
  if (seeding_) {
    hypotheses_.clear();
    seeds_->restart();
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

// The least spacing at which all streets of an area have hypotheses; nothing if that is too large.
std::optional<double> GlobalStart::spread_in(const Cells& cells) {
  for (double spacing = options_.spacing; spacing <= options_.max_spacing; spacing *= 1.25) {
    spread(cells, spacing);
    if (hypotheses_.size() < hypotheses_.capacity()) return spacing;
  }
  return std::nullopt;
}

// Stops when `max_hypotheses` are reached.
void GlobalStart::spread(const Cells& cells, double spacing) {
  hypotheses_.clear();
  const int every = std::max(static_cast<int>(spacing / StreetGrid::kCell), 1);
  for (int row = cells.low + every / 2; row < cells.high; row += every) {
    for (int column = cells.left + every / 2; column < cells.right; column += every) {
      const Eigen::Vector2d p = grid_.middle(column, row);
      if (!grid_.street(p.x(), p.y())) continue;
      for_street_directions(grid_, p, [&](size_t, double yaw) {
        for (const double reversed : {0.0, std::numbers::pi}) {
          if (hypotheses_.size() == hypotheses_.capacity()) return;
          hypotheses_.push_back(
              begin_hypothesis({p.x(), p.y(), wrap_angle(yaw + reversed)}, spacing, options_));
        }
      });
      if (hypotheses_.size() == hypotheses_.capacity()) return;
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
  // After a gap no more than in a second: the caller waits.
  const int many = static_cast<int>(options_.max_seeded * std::min(seconds, 1.0));
  if (seeding_) return seed(many);
  go_on_comparing(pending_.empty() ? options_.max_compared : many);
}

void GlobalStart::seed(int comparisons) {
  const bool added = collected_.length >= options_.independent_length ||
                     std::abs(collected_.motion.yaw) > kStepYaw;
  if (added) {
    seeds_->add(collected_);
    collected_ = {};
  }
  if (!added && !seeds_->is_running()) return;
  if (!seeds_->search(grid_, comparisons)) return;
  if (seeds_->found().empty()) return restart();
  seeding_ = false;
  hypotheses_.swap(seeds_->found());
  pending_.assign(seeds_->since().begin(), seeds_->since().end());
  // How well they fit is judged by the drive since: before, they came on to their streets.
  for (StreetHypothesis& hypothesis : hypotheses_) hypothesis.misfit = 0;
  driven_ = collected_.length;
  for (const DriveStretch& stretch : pending_) driven_ += stretch.length;
  next_ = hypotheses_.size();
}

// Takes the next stretch of the drive, if there is one.
bool GlobalStart::begin_comparison() {
  if (!pending_.empty()) {
    compared_ = pending_.front();
    pending_.erase(pending_.begin());
  } else if (collected_.length >= options_.step || std::abs(collected_.motion.yaw) > kStepYaw) {
    compared_ = collected_;
    collected_ = {};
  } else {
    return false;
  }
  since_merge_ += compared_.length;
  turned_ += compared_.motion.yaw;
  if (since_merge_ >= kMergeEvery) {
    drop_and_merge();
    const auto found = find();
    if (found && driven_ > kMinDriven && found->misfit > kNoStreet) {
      restart();
      return false;
    }
    count_alone(found && found->elsewhere < options_.max_elsewhere);
    since_merge_ = 0;
  }
  next_ = 0;
  return true;
}

// A turn is worth something once the streets of it lie behind, so that they can have refuted it.
void GlobalStart::count_alone(bool alone) {
  alone_ = alone ? alone_ + since_merge_ + options_.turn_worth * turns_.front() : 0;
  std::shift_left(turns_.begin(), turns_.end(), 1);
  turns_.back() = std::abs(turned_) > kMinTurn ? std::abs(turned_) : 0;
  if (!alone) turns_.fill(0);
  turned_ = 0;
}

void GlobalStart::go_on_comparing(int comparisons) {
  for (; comparisons > 0; --comparisons) {
    if (next_ >= hypotheses_.size() && !begin_comparison()) return;
    if (next_ < hypotheses_.size()) advance(hypotheses_[next_++], grid_, compared_, options_);
  }
}

// Pose of a hypothesis with the motion that it has not been compared after.
PlanarPose GlobalStart::now(size_t hypothesis) const {
  PlanarPose pose = hypotheses_[hypothesis].pose;
  if (hypothesis >= next_) pose = pose.compose(compared_.motion);
  for (const DriveStretch& stretch : pending_) pose = pose.compose(stretch.motion);
  return pose.compose(collected_.motion);
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
