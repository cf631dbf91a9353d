#include "fusion/streetmap/place_check.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fusion/geometry/plane_length.hpp"

namespace infuse::streetmap {
namespace {

constexpr double kChiSquared99 = 9.21;   // of two
constexpr double kMinLogOdds = -9;       // later evidence can outweigh it
constexpr double kStepSigma = 0.7;       // m, a place moves to a better pose nearby
constexpr double kStepYawSigma = 0.015;  // rad
constexpr int kTriesPerPlace = 20;

/// The rigid transform that takes `from` to `to`.
PlanarPose transform_between(const PlanarPose& from, const PlanarPose& to) {
  return to.compose(from.motion_to({}));
}

}  // namespace

std::optional<std::string> PlaceCheckOptions::invalid() const {
  if (!(spacing >= 1 && max_along > spacing && max_across > spacing && max_along <= 200 &&
        max_across <= 200 && max_distance > 0 && max_distance <= 200)) {
    return "place_check: spacing must be 1 m or more, distances up to 200 m";
  }
  if (like_places < 0 || like_places > 1000) return "place_check: like_places must be 0 … 1000";
  if (!(prior_odds > 0 && max_elsewhere > 0 && max_elsewhere < 1)) {
    return "place_check: prior_odds must be positive, max_elsewhere within 0 … 1";
  }
  return std::nullopt;
}

PlaceCheck::PlaceCheck(const PlaceCheckOptions& options, uint64_t seed)
    : options_(options), random_(seed) {
  const double directions = 2 * (options.max_along + options.max_across) / options.spacing + 8;
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
    add(pose, pose.compose({0, side * options_.spacing / 2, std::numbers::pi}), map,
        Direction::kElsewhere);
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
  running_ = true;
}

void PlaceCheck::update(const PlanarPose& estimate, const Eigen::Matrix3d& covariance, double gain,
                        const std::function<double(const PlanarPose&)>& score) {
  if (!running_) return;
  const Eigen::Matrix2d information =
      (covariance.topLeftCorner<2, 2>() + 1e-6 * Eigen::Matrix2d::Identity()).inverse();
  const double estimate_score = score(estimate);
  for (Place& place : places_) {
    const PlanarPose pose = place.T.compose(estimate);
    const Eigen::Vector2d d(pose.x - estimate.x, pose.y - estimate.y);
    place.same = d.dot(information * d) < kChiSquared99 &&
                 std::abs(wrap_angle(pose.yaw - estimate.yaw)) < 0.5;
    const PlanarPose step{kStepSigma * normal_(random_), kStepSigma * normal_(random_),
                          kStepYawSigma * normal_(random_)};
    const PlanarPose moved = pose.compose(step);
    double best = score(pose);
    if (const double other = score(moved); other > best) {
      best = other;
      place.T = transform_between(estimate, moved);
    }
    place.log_odds = std::max(place.log_odds + gain * (best - estimate_score), kMinLogOdds);
  }
  estimate_ = estimate;
  judge();
}

void PlaceCheck::judge() {
  double sum = 0, largest = 0;
  for (const Place& place : places_) {
    if (place.same) continue;
    const double odds = options_.prior_odds * std::exp(place.log_odds);
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
    if (!place.same && (best == nullptr || place.log_odds > best->log_odds)) best = &place;
  }
  if (best == nullptr || best->log_odds < options_.min_better) return std::nullopt;
  best->log_odds = 0;
  return best->T.compose(estimate_);
}

}  // namespace infuse::streetmap
