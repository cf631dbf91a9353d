#pragma once

#include <cstdint>

namespace infuse::streetmap {

/// What a segment of a street map stands for.
enum class SegmentKind : uint8_t {
  kOpenLand = 0,     ///< what no element of the map covers
  kCarriageway = 1,  ///< driven on
  kKerb = 2,         ///< boundary line of a carriageway
  kSidewalk = 3,     ///< pavement that the map does not draw but tells of by a tag
  kFootway = 4,      ///< footway, cycleway, path
  kCrossing = 5,     ///< footway on a carriageway
  kGreen = 6,        ///< park, grass, wood
  kWater = 7,
  kPaved = 8,         ///< square, parking place
  kBuilding = 9,      ///< inside of a building
  kWall = 10,         ///< boundary line of a building
  kImageRegion = 11,  ///< closed region of a map given as an image
  kImageLine = 12,    ///< boundary line of a map given as an image
};
inline constexpr int kSegmentKindCount = 13;

/// The kind in lower case: "carriageway".
const char* name(SegmentKind kind);

/// A region or line of a street map with an id of its own, I 3.2.1.
struct Segment {
  SegmentKind kind = SegmentKind::kOpenLand;
  int64_t osm_id = 0;  ///< OpenStreetMap's id of the way or relation that it was made of; 0: none

  bool operator==(const Segment&) const = default;
};

}  // namespace infuse::streetmap
