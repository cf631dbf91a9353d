#include "fusion/places/place_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/places/outline_alignment.hpp"

namespace infuse::places {
namespace {

constexpr size_t kKeptPlaces = 6;  // prepared clouds; bounds memory
constexpr double kSamePose = 1;    // m, between two results of one place (decision 17)
// Shares of a search, as in `ClosureCheckOptions`: what has less is improbable beyond counting, and
// not registered from the other side (decision 17).
constexpr double kMinInliers = 0.3, kMinAgreement = 0.6, kMinOverlap = 0.1;

}  // namespace

std::optional<std::string> PlaceMatcherOptions::invalid() const {
  if (auto wrong = check.invalid()) return wrong;
  if (candidates < 1 || candidates > 100) return "candidates must be between 1 and 100";
  if (!(distinct > 0 && max_distance > 0)) return "distances must be positive";
  return std::nullopt;
}

PlaceMatcher::PlaceMatcher(PlaceMap map, const Eigen::Isometry3d& T_vehicle_lidar,
                           const PlaceMatcherOptions& options)
    : map_(std::move(map)),
      T_vehicle_lidar_(T_vehicle_lidar),
      options_(options),
      index_(map_.descriptors) {}

Result<PlaceMatcher::PreparedPtr> PlaceMatcher::prepare(size_t keyframe) {
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

Result<PlaceComparison> PlaceMatcher::verify(size_t keyframe, const mapping::PreparedSubmap& source,
                                             const Eigen::Isometry3d& T_map_vehicle_guess,
                                             const mapping::ClosureCheckOptions& check) {
  const auto target = prepare(keyframe);
  if (!target) return tl::unexpected(target.error());
  const Eigen::Isometry3d T_map_lidar = map_.T_map_vehicle[keyframe] * map_.T_vehicle_lidar;
  const mapping::ClosureCheck found = mapping::check_closure(
      **target, source, T_map_lidar.inverse() * T_map_vehicle_guess * T_vehicle_lidar_, check);
  PlaceComparison out;
  out.fit = {found.inliers, found.agreement};
  if (!found.usable()) return out;
  const Eigen::Isometry3d& T_target_source = found.registration.T_target_source;
  MatchedPlace matched;
  matched.fit = out.fit;
  matched.T_map_vehicle = T_map_lidar * T_target_source * T_vehicle_lidar_.inverse();
  // exp(δ) T = T exp(Ad(T⁻¹) δ), then from the lidar to the vehicle.
  matched.covariance = geometry::transform_covariance(T_vehicle_lidar_ * T_target_source.inverse(),
                                                      found.registration.covariance);
  out.place = matched;
  return out;
}

// The places that look most like the cloud, far apart from each other.
std::vector<PlaceCandidate> PlaceMatcher::look_alikes(const mapping::Submap& cloud) const {
  const auto position = [&](const PlaceCandidate& candidate) -> Eigen::Vector3d {
    return map_.T_map_vehicle[candidate.place].translation();
  };
  std::vector<PlaceCandidate> out;
  for (const PlaceCandidate& candidate :
       index_.find(describe_place(cloud.points(), T_vehicle_lidar_),
                   kSearchedPerPlace * options_.candidates)) {
    if (out.size() == options_.candidates) break;
    const bool is_near = std::any_of(out.begin(), out.end(), [&](const PlaceCandidate& chosen) {
      return (position(chosen) - position(candidate)).norm() < options_.distinct;
    });
    if (!is_near) out.push_back(candidate);
  }
  return out;
}

Result<PlaceSearch> PlaceMatcher::search(const mapping::Submap& cloud) {
  const mapping::PreparedSubmap source(cloud, options_.check);
  mapping::ClosureCheckOptions check = options_.check;
  check.min_inliers = kMinInliers;
  check.min_agreement = kMinAgreement;
  check.min_overlap = kMinOverlap;
  std::vector<MatchedPlace> found;
  for (const PlaceCandidate& candidate : look_alikes(cloud)) {
    const auto target = prepare(candidate.place);
    if (!target) return tl::unexpected(target.error());
    const Eigen::Isometry3d T_place_query =
        align_outlines((*target)->cloud.cloud.points(), map_.T_vehicle_lidar,
                       source.cloud.cloud.points(), T_vehicle_lidar_, candidate.similarity.yaw);
    const auto compared =
        verify(candidate.place, source, map_.T_map_vehicle[candidate.place] * T_place_query, check);
    if (!compared) return tl::unexpected(compared.error());
    if (compared->place) found.push_back(*compared->place);
  }
  std::stable_sort(found.begin(), found.end(), [](const MatchedPlace& a, const MatchedPlace& b) {
    return log_odds(a.fit) > log_odds(b.fit);
  });
  // Two keyframes can lead to one pose.
  PlaceSearch out;
  std::vector<PlaceFit> fits;
  for (const MatchedPlace& place : found) {
    const bool is_known =
        std::any_of(out.places.begin(), out.places.end(), [&](const MatchedPlace& better) {
          return (better.T_map_vehicle.translation() - place.T_map_vehicle.translation()).norm() <
                 kSamePose;
        });
    if (is_known) continue;
    out.places.push_back(place);
    fits.push_back(place.fit);
  }
  out.probabilities = place_probabilities(fits);
  return out;
}

Result<PlaceComparison> PlaceMatcher::match(size_t keyframe, const mapping::Submap& cloud,
                                            const Eigen::Isometry3d& T_map_vehicle_guess) {
  return verify(keyframe, mapping::PreparedSubmap(cloud, options_.check), T_map_vehicle_guess,
                options_.check);
}

std::optional<size_t> PlaceMatcher::nearest_keyframe(const Eigen::Isometry3d& T_map_vehicle) const {
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

}  // namespace infuse::places
