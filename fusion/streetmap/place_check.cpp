#include "fusion/streetmap/place_check.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fusion/geometry/plane_length.hpp"

namespace infuse::streetmap {
namespace {

constexpr double kChiSquared99 = 9.21;   // 99 % of χ² with 2 degrees of freedom
constexpr double kMaxSameYaw = 0.5;      // rad: further, it heads elsewhere
constexpr double kMinLogOdds = -9;       // one in 8100: later evidence can outweigh it
constexpr double kStepSigma = 0.7;       // m, a place moves to a better pose nearby
constexpr double kStepYawSigma = 0.015;  // rad
constexpr int kTriesPerPlace = 20;       // bounds time
constexpr double kMinContender = -4;  // log-odds, one in 55, above which more poses are attempted
constexpr int kAttempts = 3;

}  // namespace

bool PlaceCheckOptions::is_better(double log_odds) const {
  return log_odds + std::log(prior_odds) >= min_better;
}

bool is_in_region(const PlanarPose& pose, const PlanarPose& estimate,
                  const Eigen::Matrix2d& covariance) {
  const Eigen::Vector2d d(pose.x - estimate.x, pose.y - estimate.y);
  const Eigen::Matrix2d regular = covariance + 1e-6 * Eigen::Matrix2d::Identity();
  return d.dot(regular.inverse() * d) < kChiSquared99 &&
         std::abs(wrap_angle(pose.yaw - estimate.yaw)) < kMaxSameYaw;
}

std::optional<std::string> PlaceCheckOptions::invalid() const {
  if (!(spacing >= 1 && max_along > spacing && max_across > spacing && max_along <= 200 &&
        max_across <= 200 && max_distance > 0 && max_distance <= 200)) {
    return "place_check: spacing must be 1 m or more, distances up to 200 m";
  }
  if (like_places < 0 || like_places > 1000)
    return "place_check: like_places must be between 0 and 1000";
  if (!(prior_odds > 0 && max_elsewhere > 0 && max_elsewhere < 1)) {
    return "place_check: prior_odds must be positive, max_elsewhere between 0 and 1";
  }
  return std::nullopt;
}

PlaceCheck::PlaceCheck(const PlaceCheckOptions& options, uint64_t seed)
    : options_(options), random_(seed) {
  const double directions = (4 * options.max_along + 2 * options.max_across) / options.spacing + 8;
  places_.reserve(static_cast<size_t>(directions) + static_cast<size_t>(options.like_places));
}

void PlaceCheck::add(const PlanarPose& from, const PlanarPose& to, const SegmentMap& map,
                     Direction direction) {
  if (map.covers(to.x, to.y)) places_.push_back({transform_between(from, to), direction});
}

void PlaceCheck::start(const PlanarPose& pose, const SegmentMap& map) {
  places_.clear();
  for (const double side : {-1.0, 1.0}) {
    for (double d = options_.spacing; d <= options_.max_along; d += options_.spacing) {
      add(pose, pose.compose({side * d, 0, 0}), map, Direction::kAlong);
    }
    for (double d = options_.spacing; d <= options_.max_across; d += options_.spacing) {
      add(pose, pose.compose({0, side * d, 0}), map, Direction::kAcross);
    }
    // Reversed along the street, in either lane by turns.
    double lane = side * options_.spacing / 2;
    for (double d = 0; d <= options_.max_along; d += options_.spacing, lane = -lane) {
      add(pose, pose.compose({side * d, lane, std::numbers::pi}), map, Direction::kElsewhere);
    }
  }
  std::uniform_real_distribution<double> share(-1, 1);
  int wanted = options_.like_places;
  for (int i = 0; i < kTriesPerPlace * options_.like_places && wanted > 0; ++i) {
    const PlanarPose other{pose.x + options_.max_distance * share(random_),
                           pose.y + options_.max_distance * share(random_),
                           wrap_angle(pose.yaw + options_.like_yaw * normal_(random_))};
    if (geometry::plane_length(other.x - pose.x, other.y - pose.y) < options_.spacing) continue;
    const uint32_t id = map.id_at(other.x, other.y);
    if (map.segment(id).kind != SegmentKind::kCarriageway) continue;
    add(pose, other, map, Direction::kElsewhere);
    --wanted;
  }
  estimate_ = pose;
  elsewhere_ = 1;
  first_view_ = true;
  running_ = true;
}

void PlaceCheck::update(const PlanarPose& estimate, const Eigen::Matrix2d& covariance, double gain,
                        const std::function<double(const PlanarPose&)>& score,
                        const std::function<double(const PlanarPose&)>& by_drive) {
  if (!running_) return;
  const double estimate_score = score(estimate);
  for (Place& place : places_) {
    const PlanarPose pose = place.T.compose(estimate);
    place.same = is_in_region(pose, estimate, covariance);
    const double change = gain * (place_score(place, estimate, score) - estimate_score);
    place.log_odds =
        std::max(place.log_odds + (first_view_ ? std::min(change, 0.0) : change), kMinLogOdds);
    place.by_drive = by_drive(pose);
  }
  first_view_ = false;
  estimate_ = estimate;
  judge();
}

// The estimate is the best of many poses nearby, and so must the other place be: it moves to a
// better one of those about it on the first view, of random ones near it on each. The view that it
// is moved by does not support it: it counts by its pose before, the first view against it only.
double PlaceCheck::place_score(Place& place, const PlanarPose& estimate,
                               const std::function<double(const PlanarPose&)>& score) {
  PlanarPose pose = place.T.compose(estimate);
  const double before = score(pose);
  double best = before;
  const auto attempt = [&](const PlanarPose& moved) {
    const double other = score(moved);
    if (other <= best) return;
    best = other;
    pose = moved;
  };
  if (first_view_) {
    const PlanarPose middle = pose;
    const double step = options_.spacing / 3;
    for (const double x : {-step, 0.0, step}) {
      for (const double y : {-step, 0.0, step}) {
        if (x != 0 || y != 0) attempt(middle.compose({x, y, 0}));
      }
    }
  }
  const int attempts = place.log_odds > kMinContender ? kAttempts : 1;
  for (int i = 0; i < attempts; ++i) {
    attempt(pose.compose({kStepSigma * normal_(random_), kStepSigma * normal_(random_),
                          kStepYawSigma * normal_(random_)}));
  }
  place.T = transform_between(estimate, pose);
  return first_view_ ? best : before;
}

void PlaceCheck::judge() {
  double sum = 0, largest = 0;
  for (const Place& place : places_) {
    if (place.same) continue;
    const double odds = options_.prior_odds * std::exp(place.total());
    sum += odds;
    if (odds < largest) continue;
    largest = odds;
    likeliest_ = place.direction;
  }
  elsewhere_ = sum / (1 + sum);
  if (elsewhere_ < options_.max_elsewhere) running_ = false;
}

const char* PlaceCheck::reason() const {
  if (!running_) return "";
  switch (likeliest_) {
    case Direction::kAlong:
      return "the place along the street is not confirmed";
    case Direction::kAcross:
      return "the place across the street is not confirmed";
    case Direction::kElsewhere:
      break;
  }
  return "another street or direction is not ruled out";
}

std::optional<PlanarPose> PlaceCheck::propose() {
  if (!running_) return std::nullopt;
  Place* best = nullptr;
  for (Place& place : places_) {
    if (!place.same && (best == nullptr || place.total() > best->total())) best = &place;
  }
  if (best == nullptr || !options_.is_better(best->total())) return std::nullopt;
  best->log_odds = -best->by_drive;  // again only by further evidence
  return best->T.compose(estimate_);
}

}  // namespace infuse::streetmap
