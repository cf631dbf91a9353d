#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/mapping/keyframes.hpp"
#include "fusion/places/place_descriptor.hpp"

namespace infuse::places {

/// Which of the places that see the same keep their clouds.
struct PlaceSelectionOptions {
  double distance = 3;  ///< m; nearer places of one level see the same (decision 23)
  double min_seen =
      0.8;  ///< share of the directions in which a place sees something, in which the
            ///< newer one does too: lidars that see a part of the circle (decision 23)

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Keyframes that keep their clouds, in order: of those that have one, the newest, and each that no
/// newer one kept replaces. Visits that see the same add none; those that each see another part of
/// the circle, less than `min_seen` of it in common, keep one each.
/// `T_map_vehicle` and `places` have an entry for every keyframe; `options.invalid()` must be
/// empty.
std::vector<size_t> select_places(const std::vector<mapping::Keyframe>& keyframes,
                                  const std::vector<Eigen::Isometry3d>& T_map_vehicle,
                                  const std::vector<PlaceDescriptor>& places,
                                  const PlaceSelectionOptions& options);

}  // namespace infuse::places
