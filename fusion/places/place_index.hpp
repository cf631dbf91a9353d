#pragma once

#include <cstddef>
#include <vector>

#include "fusion/places/place_descriptor.hpp"

namespace infuse::places {

/// m; places that are farther apart are different answers (decision 17).
inline constexpr double kDistinctPlaces = 10;

/// Places that look alike and are looked at for each that is verified, as neighbours look alike too
/// (decision 17).
inline constexpr size_t kSearchedPerPlace = 6;

/// A place that looks like the one sought.
struct PlaceCandidate {
  size_t place = 0;            ///< index
  PlaceSimilarity similarity;  ///< how alike
};

/// Places of a map, searched by what they look like.
class PlaceIndex {
 public:
  /// Builds the search.
  explicit PlaceIndex(std::vector<PlaceDescriptor> places);

  size_t size() const { return places_.size(); }  ///< number of places

  /// Returns at most `count` places, the most alike first: those with the nearest keys, compared in
  /// full. 10 000 places take a millisecond or two.
  std::vector<PlaceCandidate> find(const PlaceDescriptor& query, size_t count) const;

 private:
  std::vector<PlaceDescriptor> places_;
  std::vector<PlaceKey> keys_;
};

}  // namespace infuse::places
