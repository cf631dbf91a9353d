#pragma once

#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/mapping/closure_check.hpp"
#include "fusion/places/place_index.hpp"
#include "fusion/places/place_probability.hpp"

namespace infuse::places {

/// Height between a vehicle and a keyframe of its level at most, m (decision 17).
inline constexpr double kMaxLevel = 4;

/// Map of keyframes on which a vehicle is localised.
struct PlaceMap {
  std::vector<Eigen::Isometry3d> T_map_vehicle;                       ///< by keyframe
  Eigen::Isometry3d T_vehicle_lidar = Eigen::Isometry3d::Identity();  ///< of the map's lidar
  std::vector<PlaceDescriptor> descriptors;                           ///< by keyframe
  /// Reads the cloud of a keyframe (frame of the map's lidar there).
  std::function<Result<mapping::Submap>(size_t keyframe)> read_cloud;
};

/// Settings of the comparison of a cloud with the places of a map (decision 17).
struct PlaceMatcherOptions {
  mapping::ClosureCheckOptions check;  ///< near a pose that is known
  size_t candidates = 4;               ///< places that a search verifies, …
  double distinct = kDistinctPlaces;   ///< … m apart at least
  double max_distance = 12;            ///< m; farther from every keyframe a pose is off the map

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Pose on the map that verification accepts.
struct MatchedPlace {
  Eigen::Isometry3d T_map_vehicle;
  geometry::Matrix6 covariance;  ///< right perturbation, vehicle frame, rad and m
  PlaceFit fit;
};

/// What a comparison with one place found.
struct PlaceComparison {
  PlaceFit fit;                       ///< also where verification does not accept the pose
  std::optional<MatchedPlace> place;  ///< where it does
};

/// What a search found.
struct PlaceSearch {
  std::vector<MatchedPlace> places;  ///< the best fit first
  PlaceProbabilities probabilities;
};

/// Compares what a lidar saw with the places of a map. Reads their clouds when they are needed and
/// keeps the last few.
class PlaceMatcher {
 public:
  /// `options.invalid()` must be empty; `map.descriptors` has as many entries as keyframes.
  PlaceMatcher(PlaceMap map, const Eigen::Isometry3d& T_vehicle_lidar,
               const PlaceMatcherOptions& options = {});

  /// Poses on the map from which a cloud (lidar frame) could have been seen: the places that look
  /// most alike, verified. Or why the map cannot be read.
  Result<PlaceSearch> search(const mapping::Submap& cloud);

  /// The pose at a keyframe from a guess that is right within 2 m, and how well the cloud fits.
  Result<PlaceComparison> match(size_t keyframe, const mapping::Submap& cloud,
                                const Eigen::Isometry3d& T_map_vehicle_guess);

  /// Keyframe nearest to a pose of the same level, within `max_distance`.
  std::optional<size_t> nearest_keyframe(const Eigen::Isometry3d& T_map_vehicle) const;

 private:
  using PreparedPtr = std::shared_ptr<const mapping::PreparedSubmap>;

  Result<PreparedPtr> prepare(size_t keyframe);
  std::vector<PlaceCandidate> look_alikes(const mapping::Submap& cloud) const;
  Result<PlaceComparison> verify(size_t keyframe, const mapping::PreparedSubmap& source,
                                 const Eigen::Isometry3d& T_map_vehicle_guess,
                                 const mapping::ClosureCheckOptions& check);

  PlaceMap map_;
  Eigen::Isometry3d T_vehicle_lidar_;
  PlaceMatcherOptions options_;
  PlaceIndex index_;
  std::list<std::pair<size_t, PreparedPtr>> prepared_;  // the latest first
};

}  // namespace infuse::places
