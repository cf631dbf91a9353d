#include "fusion/places/localiser.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/places/outline_alignment.hpp"

namespace infuse::places {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr size_t kKeptPlaces = 6;  // prepared clouds
constexpr double kMaxLevel = 4;    // m of height between a vehicle and a keyframe of its level

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
  if (auto wrong = check.invalid()) return wrong;
  if (candidates < 1 || candidates > 100) return "candidates must lie in 1 … 100";
  for (const double length :
       {distinct, confirm_distance, max_unconfirmed, lost_after, max_distance, max_sigma, gate}) {
    if (!(length > 0)) return "distances must be positive";
  }
  for (const double share :
       {min_search_inliers, min_search_agreement, min_search_overlap, max_runner_up}) {
    if (!(share >= 0 && share <= 1)) return "shares must lie in 0 … 1";
  }
  if (standing_sweeps < 1 || max_failures < 1) return "numbers must be positive";
  return std::nullopt;
}

Localiser::Localiser(PlaceMap map, const Eigen::Isometry3d& T_vehicle_lidar,
                     const LocaliserOptions& options)
    : map_(std::move(map)),
      T_vehicle_lidar_(T_vehicle_lidar),
      options_(options),
      index_(map_.descriptors),
      picker_(options.keyframes),
      submap_(options.submaps) {}

Result<LocaliserPose> Localiser::add(const geometry::PointsView& points,
                                     std::span<const float> reflectivity,
                                     const mapping::SweepMotion& motion) {
  const Eigen::Isometry3d T_before_odom = picker_.T_odom_vehicle().inverse();
  const std::optional<Query> query = next_query(points, reflectivity, motion);
  const double seconds = to_seconds(motion.stamp - std::exchange(pose_.stamp, motion.stamp));
  pose_.verified = false;
  if (pose_.state != LocaliserState::kLost) {
    predict(motion, T_before_odom * picker_.T_odom_vehicle(), seconds);
  }
  if (query) {
    const auto done = pose_.state == LocaliserState::kLost ? search(*query) : check(*query);
    if (!done) return tl::unexpected(done.error());
  }
  if (pose_.state != LocaliserState::kLost) judge();
  return pose_;
}

// The submap of the last metres when the next one begins, or of a vehicle that stands and is lost.
std::optional<Localiser::Query> Localiser::next_query(const geometry::PointsView& points,
                                                      std::span<const float> reflectivity,
                                                      const mapping::SweepMotion& motion) {
  const mapping::Keyframe before = picker_.last();
  const bool started = picker_.started();
  const bool is_keyframe = picker_.add(motion);
  if (!picker_.started()) return std::nullopt;
  const bool stands =
      pose_.state == LocaliserState::kLost && sweeps_in_submap_ == options_.standing_sweeps;
  std::optional<Query> query;
  if (started && is_keyframe) {
    query = Query{before.T_odom_vehicle, before.way, submap_.take()};
    sweeps_in_submap_ = 0;
  } else if (stands) {
    query = Query{before.T_odom_vehicle, before.way, submap_.take()};
    ++sweeps_in_submap_;
  }
  if (motion.registered || is_keyframe) {
    const Eigen::Isometry3d T_keyframe_vehicle =
        picker_.last().T_odom_vehicle.inverse() * picker_.T_odom_vehicle();
    submap_.add(points, reflectivity,
                T_vehicle_lidar_.inverse() * T_keyframe_vehicle * T_vehicle_lidar_);
    ++sweeps_in_submap_;
  }
  return query;
}

Result<Localiser::PreparedPtr> Localiser::prepare(size_t keyframe) {
  const auto kept = std::find_if(prepared_.begin(), prepared_.end(),
                                 [&](const auto& entry) { return entry.first == keyframe; });
  if (kept != prepared_.end()) {
    prepared_.splice(prepared_.begin(), prepared_, kept);
    return prepared_.front().second;
  }
  const auto cloud = map_.read_cloud(keyframe);
  if (!cloud) return tl::unexpected(cloud.error());
  if (prepared_.size() == kKeptPlaces) prepared_.pop_back();
  prepared_.emplace_front(keyframe,
                          std::make_shared<const mapping::PreparedSubmap>(*cloud, options_.check));
  return prepared_.front().second;
}

Result<std::optional<Localiser::Verified>> Localiser::verify(
    size_t keyframe, const mapping::PreparedSubmap& source,
    const Eigen::Isometry3d& T_map_vehicle_guess) {
  const auto target = prepare(keyframe);
  if (!target) return tl::unexpected(target.error());
  const Eigen::Isometry3d T_map_lidar = map_.T_map_vehicle[keyframe] * map_.T_vehicle_lidar;
  const mapping::ClosureCheck found = mapping::check_closure(
      **target, source, T_map_lidar.inverse() * T_map_vehicle_guess * T_vehicle_lidar_,
      options_.check);
  if (!found.usable()) return std::optional<Verified>();
  const Eigen::Isometry3d& T_target_source = found.registration.T_target_source;
  Verified verified;
  verified.score = found.agreement * found.overlap;
  verified.distinctive = found.inliers >= options_.min_search_inliers &&
                         found.agreement >= options_.min_search_agreement &&
                         found.overlap >= options_.min_search_overlap;
  verified.T_map_vehicle = T_map_lidar * T_target_source * T_vehicle_lidar_.inverse();
  // exp(δ) T = T exp(Ad(T⁻¹) δ), then from the lidar to the vehicle.
  verified.covariance = geometry::transform_covariance(T_vehicle_lidar_ * T_target_source.inverse(),
                                                       found.registration.covariance);
  return std::optional(verified);
}

// The places that look alike, far apart from each other, are verified; a second one that fits
// nearly as well leaves the vehicle lost.
Result<void> Localiser::search(const Query& query) {
  const mapping::PreparedSubmap source(query.submap, options_.check);
  const PlaceDescriptor shape = describe_place(query.submap.points(), T_vehicle_lidar_);
  const auto position = [&](size_t keyframe) -> Eigen::Vector3d {
    return map_.T_map_vehicle[keyframe].translation();
  };
  constexpr size_t kSearched = 6;  // times the candidates: neighbours look alike
  std::vector<PlaceCandidate> tried;
  std::vector<Verified> found;
  for (const PlaceCandidate& candidate : index_.find(shape, kSearched * options_.candidates)) {
    if (tried.size() == options_.candidates) break;
    const bool is_near = std::any_of(tried.begin(), tried.end(), [&](const PlaceCandidate& t) {
      return (position(t.place) - position(candidate.place)).norm() < options_.distinct;
    });
    if (is_near) continue;
    tried.push_back(candidate);
    const auto target = prepare(candidate.place);
    if (!target) return tl::unexpected(target.error());
    const Eigen::Isometry3d T_place_query =
        align_outlines((*target)->cloud.cloud.points(), map_.T_vehicle_lidar,
                       source.cloud.cloud.points(), T_vehicle_lidar_, candidate.similarity.yaw);
    const auto verified =
        verify(candidate.place, source, map_.T_map_vehicle[candidate.place] * T_place_query);
    if (!verified) return tl::unexpected(verified.error());
    if (*verified) found.push_back(**verified);
  }
  pose_.reason = "no place of the map is recognised";
  if (found.empty()) return {};
  const auto by_score = [](const Verified& x, const Verified& y) { return x.score < y.score; };
  const Verified best = *std::max_element(found.begin(), found.end(), by_score);
  const bool is_alone = std::none_of(found.begin(), found.end(), [&](const Verified& other) {
    constexpr double kSamePlace = 1;  // m
    return other.score > options_.max_runner_up * best.score &&
           (other.T_map_vehicle.translation() - best.T_map_vehicle.translation()).norm() >
               kSamePlace;
  });
  if (!is_alone) {
    pose_.reason = "two places of the map fit";
  } else if (best.distinctive) {
    begin_at(best, query);
  }
  return {};
}

void Localiser::begin_at(const Verified& found, const Query& query) {
  const Eigen::Isometry3d T_query_now = query.T_odom_vehicle.inverse() * picker_.T_odom_vehicle();
  pose_.state = LocaliserState::kUnsure;
  pose_.T_map_vehicle = found.T_map_vehicle * T_query_now;
  pose_.covariance = geometry::transform_covariance(T_query_now.inverse(), found.covariance);
  recognised_way_ = confirmed_way_ = query.way;
  failures_ = 0;
  confirmed_ = false;
  mismatch_ = "";
}

// Verifies the pose at the place of the query, and corrects it.
Result<void> Localiser::check(const Query& query) {
  const Eigen::Isometry3d T_query_now = query.T_odom_vehicle.inverse() * picker_.T_odom_vehicle();
  const Eigen::Isometry3d T_map_vehicle = pose_.T_map_vehicle * T_query_now.inverse();
  const auto keyframe = nearest_keyframe(T_map_vehicle);
  if (!keyframe) {
    mismatch_ = "off the map";
    return {};
  }
  const mapping::PreparedSubmap source(query.submap, options_.check);
  const auto verified = verify(*keyframe, source, T_map_vehicle);
  if (!verified) return tl::unexpected(verified.error());
  if (!*verified) mismatch_ = "the map does not fit";
  pose_.verified = *verified && update(**verified, T_query_now);
  failures_ = pose_.verified ? 0 : failures_ + 1;
  if (!pose_.verified) return {};
  mismatch_ = "";
  confirmed_ = confirmed_ || query.way - recognised_way_ >= options_.confirm_distance;
  confirmed_way_ = query.way;
  return {};
}

std::optional<size_t> Localiser::nearest_keyframe(const Eigen::Isometry3d& T_map_vehicle) const {
  std::optional<size_t> nearest;
  double least = options_.max_distance * options_.max_distance;
  const Eigen::Vector3d p = T_map_vehicle.translation();
  for (size_t k = 0; k < map_.T_map_vehicle.size(); ++k) {
    const Eigen::Vector3d q = map_.T_map_vehicle[k].translation();
    const double distance = (p - q).head<2>().squaredNorm();
    if (distance >= least || std::abs(p.z() - q.z()) > kMaxLevel) continue;
    least = distance;
    nearest = k;
  }
  return nearest;
}

void Localiser::predict(const mapping::SweepMotion& motion, const Eigen::Isometry3d& T_from_to,
                        double seconds) {
  const mapping::KeyframeOptions& noise = options_.keyframes;
  const double root = std::sqrt(T_from_to.translation().norm());
  const Matrix6 step = motion.measured ? motion.covariance
                                       : independent_noise(noise.unmeasured_rotation * seconds,
                                                           noise.unmeasured_translation * seconds);
  pose_.T_map_vehicle = pose_.T_map_vehicle * T_from_to;
  pose_.T_map_vehicle.linear() =
      Eigen::Quaterniond(pose_.T_map_vehicle.linear()).normalized().toRotationMatrix();
  pose_.covariance = geometry::transform_covariance(T_from_to.inverse(), pose_.covariance + step) +
                     independent_noise(noise.rotation_drift * root, noise.translation_drift * root);
}

// Kalman update by a pose. What the keyframes' clouds are wrong by does not average out: the
// covariance stays above it.
bool Localiser::update(const Verified& measured, const Eigen::Isometry3d& T_measured_now) {
  const Matrix6 floor =
      independent_noise(options_.check.rotation_noise, options_.check.translation_noise);
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
  const double unconfirmed = picker_.way() - confirmed_way_;
  const double sigma = std::sqrt(pose_.covariance.block<3, 3>(3, 3).diagonal().maxCoeff());
  if (sigma > options_.max_sigma || unconfirmed > options_.lost_after) {
    return lose(*mismatch_ != '\0' ? mismatch_ : "no place confirms the pose");
  }
  if (!confirmed_ && failures_ > 0) return lose("the next place does not confirm the pose");
  const bool sure =
      confirmed_ && unconfirmed <= options_.max_unconfirmed && failures_ < options_.max_failures;
  pose_.state = sure ? LocaliserState::kTracking : LocaliserState::kUnsure;
  pose_.reason = sure                 ? ""
                 : !confirmed_        ? "recognised, not yet confirmed"
                 : *mismatch_ != '\0' ? mismatch_
                                      : "the map has not confirmed the pose lately";
}

}  // namespace infuse::places
