#include "fusion/places/localiser.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/measurement/rotation.hpp"

namespace infuse::places {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

/// Log odds of a comparison that verification does not accept, at most: of comparisons at the right
/// place one in ten (6 of 54 where the town has other houses, 0 of 52 where it is of today), at
/// another one nearly all.
constexpr double kNotVerified = -2.3;

Matrix6 independent_noise(double rotation, double translation) {
  Vector6 variance;
  variance.head<3>().setConstant(rotation * rotation);
  variance.tail<3>().setConstant(translation * translation);
  return variance.asDiagonal();
}

}  // namespace

const char* name_of(LocaliserState state) {
  constexpr const char* kNames[] = {"LOST", "UNSURE", "TRACKING"};
  return kNames[static_cast<size_t>(state)];
}

std::optional<std::string> LocaliserOptions::invalid() const {
  if (auto wrong = keyframes.invalid()) return wrong;
  if (auto wrong = submaps.invalid()) return wrong;
  if (auto wrong = matcher.invalid()) return wrong;
  for (const double length : {confirm_distance, max_unconfirmed, lost_after, max_sigma, gate}) {
    if (!(length > 0)) return "distances must be positive";
  }
  if (!(min_probability > 0 && min_probability < 1))
    return "min_probability must be between 0 and 1";
  if (standing_sweeps < 1) return "standing_sweeps must be positive";
  return std::nullopt;
}

Localiser::Localiser(PlaceMap map, const Eigen::Isometry3d& T_vehicle_lidar,
                     const LocaliserOptions& options)
    : options_(options),
      matcher_(std::move(map), T_vehicle_lidar, options.matcher),
      submaps_(options.keyframes, options.submaps, T_vehicle_lidar) {}

Result<LocaliserPose> Localiser::add(const geometry::PointsView& points,
                                     std::span<const float> reflectivity,
                                     const mapping::SweepMotion& motion) {
  const Eigen::Isometry3d T_before_odom = submaps_.picker().T_odom_vehicle().inverse();
  const std::optional<mapping::KeyframeSubmap> query = next_query(points, reflectivity, motion);
  const double seconds = to_seconds(motion.stamp - std::exchange(pose_.stamp, motion.stamp));
  pose_.verified = false;
  if (pose_.state != LocaliserState::kLost) {
    predict(motion, T_before_odom * submaps_.picker().T_odom_vehicle(), seconds);
  }
  if (query) {
    const auto done = pose_.state == LocaliserState::kLost ? search(*query) : check(*query);
    if (!done) return tl::unexpected(done.error());
  }
  if (pose_.state != LocaliserState::kLost) judge();
  return pose_;
}

// The submap of the last metres when the next one begins, or of a vehicle that stands and is lost.
std::optional<mapping::KeyframeSubmap> Localiser::next_query(const geometry::PointsView& points,
                                                             std::span<const float> reflectivity,
                                                             const mapping::SweepMotion& motion) {
  const size_t before = submaps_.sweeps();
  if (auto ended = submaps_.add(points, reflectivity, motion)) return ended;
  const bool stands = pose_.state == LocaliserState::kLost && submaps_.sweeps() > before &&
                      submaps_.sweeps() == options_.standing_sweeps;
  if (!stands) return std::nullopt;
  return submaps_.take();
}

// A place that is not much more probable than all others together leaves the vehicle lost.
Result<void> Localiser::search(const mapping::KeyframeSubmap& query) {
  const auto found = matcher_.search(query.submap);
  if (!found) return tl::unexpected(found.error());
  pose_.place = found->probabilities;
  if (pose_.place.best >= options_.min_probability) {
    begin_at(found->places.front(), query);
  } else {
    pose_.reason = pose_.place.runner_up > pose_.place.nowhere
                       ? "two places of the map fit"
                       : "no place of the map is recognised";
  }
  return {};
}

void Localiser::begin_at(const MatchedPlace& found, const mapping::KeyframeSubmap& query) {
  const Eigen::Isometry3d T_query_now =
      query.keyframe.T_odom_vehicle.inverse() * submaps_.picker().T_odom_vehicle();
  pose_.state = LocaliserState::kUnsure;
  pose_.T_map_vehicle = found.T_map_vehicle * T_query_now;
  pose_.covariance = geometry::transform_covariance(T_query_now.inverse(), found.covariance);
  recognised_way_ = confirmed_way_ = query.keyframe.distance_driven;
  evidence_ = 0;
  confirmed_ = false;
  mismatch_ = "";
}

// Verifies the pose at the place of the query, and corrects it.
Result<void> Localiser::check(const mapping::KeyframeSubmap& query) {
  const Eigen::Isometry3d T_query_now =
      query.keyframe.T_odom_vehicle.inverse() * submaps_.picker().T_odom_vehicle();
  const Eigen::Isometry3d T_map_vehicle = pose_.T_map_vehicle * T_query_now.inverse();
  const auto keyframe = matcher_.nearest_keyframe(T_map_vehicle);
  if (!keyframe) {
    mismatch_ = "off the map";
    return {};
  }
  const auto compared = matcher_.match(*keyframe, query.submap, T_map_vehicle);
  if (!compared) return tl::unexpected(compared.error());
  const std::optional<MatchedPlace>& matched = compared->place;
  if (!matched) mismatch_ = "the map does not fit";
  pose_.verified = matched && update(*matched, T_query_now);
  const double way = query.keyframe.distance_driven;
  // What lies closer to the first place shows the same houses once more.
  if (way - recognised_way_ >= options_.confirm_distance) {
    const double odds = log_odds(compared->fit);
    weigh(pose_.verified ? odds : std::min(odds, kNotVerified));
  }
  if (!pose_.verified) return {};
  mismatch_ = "";
  confirmed_way_ = way;
  return {};
}

// One place says no more than recognition asks for, and what was seen long ago is forgotten.
void Localiser::weigh(double log_odds) {
  const double limit = evidence_limit();
  evidence_ = std::clamp(evidence_ + std::clamp(log_odds, -limit, limit), -limit, limit);
  confirmed_ = confirmed_ || evidence_ >= limit;
}

double Localiser::evidence_limit() const {
  return std::log(options_.min_probability / (1 - options_.min_probability));
}

void Localiser::predict(const mapping::SweepMotion& motion, const Eigen::Isometry3d& T_from_to,
                        double seconds) {
  const mapping::KeyframeOptions& noise = options_.keyframes;
  const double root = std::sqrt(T_from_to.translation().norm());
  const Matrix6 step = motion.measured ? motion.covariance
                                       : independent_noise(noise.unmeasured_rotation * seconds,
                                                           noise.unmeasured_translation * seconds);
  pose_.T_map_vehicle = pose_.T_map_vehicle * T_from_to;
  pose_.T_map_vehicle.linear() = orthonormal(pose_.T_map_vehicle.linear());
  pose_.covariance = geometry::transform_covariance(T_from_to.inverse(), pose_.covariance + step) +
                     independent_noise(noise.rotation_drift * root, noise.translation_drift * root);
}

// Kalman update by a pose. What the keyframes' clouds are wrong by does not average out: the
// covariance stays above it.
bool Localiser::update(const MatchedPlace& measured, const Eigen::Isometry3d& T_measured_now) {
  const Matrix6 floor = independent_noise(options_.matcher.check.rotation_noise,
                                          options_.matcher.check.translation_noise);
  const Eigen::Isometry3d T_map_vehicle = measured.T_map_vehicle * T_measured_now;
  const Matrix6 R =
      geometry::transform_covariance(T_measured_now.inverse(), measured.covariance) + floor;
  const Matrix6 S = pose_.covariance + R;
  const Vector6 error = geometry::log(pose_.T_map_vehicle.inverse() * T_map_vehicle);
  const Eigen::LDLT<Matrix6> solver(S);
  if (!(error.dot(solver.solve(error)) < options_.gate * options_.gate + 6)) {
    mismatch_ = "the map contradicts odometry";
    return false;
  }
  const Matrix6 gain = solver.solve(pose_.covariance).transpose();
  pose_.T_map_vehicle = pose_.T_map_vehicle * geometry::exp(Vector6(gain * error));
  const Matrix6 rest = Matrix6::Identity() - gain;
  pose_.covariance = rest * pose_.covariance * rest.transpose() + gain * R * gain.transpose();
  pose_.covariance = (0.5 * (pose_.covariance + pose_.covariance.transpose())).eval();
  for (int i = 0; i < 6; ++i) {
    const double missing = floor(i, i) - pose_.covariance(i, i);
    if (missing > 0) pose_.covariance(i, i) += missing;
  }
  return true;
}

void Localiser::lose(const char* reason) {
  pose_.state = LocaliserState::kLost;
  pose_.reason = reason;
  confirmed_ = false;
}

void Localiser::judge() {
  const double unconfirmed = submaps_.picker().distance_driven() - confirmed_way_;
  const double sigma = std::sqrt(pose_.covariance.block<3, 3>(3, 3).diagonal().maxCoeff());
  if (sigma > options_.max_sigma || unconfirmed > options_.lost_after) {
    return lose(*mismatch_ != '\0' ? mismatch_ : "no place confirms the pose");
  }
  if (evidence_ <= -evidence_limit()) return lose("later sweeps contradict the map");
  const bool sure = confirmed_ && unconfirmed <= options_.max_unconfirmed && evidence_ > 0;
  pose_.state = sure ? LocaliserState::kTracking : LocaliserState::kUnsure;
  pose_.reason = sure                 ? ""
                 : !confirmed_        ? "recognised, not yet confirmed"
                 : *mismatch_ != '\0' ? mismatch_
                                      : "the map has not confirmed the pose lately";
}

}  // namespace infuse::places
