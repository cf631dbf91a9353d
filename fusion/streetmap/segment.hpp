#pragma once

#include <cstdint>

namespace infuse::streetmap {

/// Kind of a segment of a street map.
enum class SegmentKind : uint8_t {
  kOpenLand = 0,     ///< covered by no element of the map
  kCarriageway = 1,  ///< road surface between the kerbs
  kKerb = 2,         ///< boundary line of a carriageway
  kSidewalk = 3,     ///< pavement that the map gives by a tag only
  kFootway = 4,      ///< footway, cycleway, path
  kCrossing = 5,     ///< footway across a carriageway
  kGreen = 6,        ///< park, grass, wood
  kWater = 7,
  kPaved = 8,         ///< square or car park
  kBuilding = 9,      ///< inside of a building
  kWall = 10,         ///< boundary line of a building
  kImageRegion = 11,  ///< closed region of a map given as an image
  kImageLine = 12,    ///< boundary line of a map given as an image
};
inline constexpr int kSegmentKindCount = static_cast<int>(SegmentKind::kImageLine) + 1;

/// Returns the kind in lower case: "carriageway".
const char* name_of(SegmentKind kind);

/// Streets on other levels at a segment, which the drawing does not show.
enum class StreetLevels : uint8_t {
  kOne = 0,     ///< none
  kBelow = 1,   ///< a street passes below: under a bridge, in a tunnel
  kJoined = 2,  ///< streets of two levels are joined here: the end of a bridge or a tunnel
};

/// Region or line of a street map with its own id, I 3.2.1. Where there are streets on other
/// levels, an element has a second and a third segment, with the same kind and element.
struct Segment {
  SegmentKind kind = SegmentKind::kOpenLand;  ///< what it is
  int64_t osm_id = 0;                         ///< id of the OpenStreetMap way or relation; 0: none
  int8_t layer = 0;                           ///< level of a street, as `PlanStrip::layer`
  StreetLevels levels = StreetLevels::kOne;   ///< beside it

  bool operator==(const Segment&) const = default;  ///< of all
};

}  // namespace infuse::streetmap
