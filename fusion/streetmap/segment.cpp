#include "fusion/streetmap/segment.hpp"

namespace infuse::streetmap {

const char* name_of(SegmentKind kind) {
  switch (kind) {
    case SegmentKind::kOpenLand:
      return "open land";
    case SegmentKind::kCarriageway:
      return "carriageway";
    case SegmentKind::kKerb:
      return "kerb";
    case SegmentKind::kSidewalk:
      return "roadside";
    case SegmentKind::kFootway:
      return "footway";
    case SegmentKind::kCrossing:
      return "crossing";
    case SegmentKind::kGreen:
      return "green";
    case SegmentKind::kWater:
      return "water";
    case SegmentKind::kPaved:
      return "paved";
    case SegmentKind::kBuilding:
      return "building";
    case SegmentKind::kWall:
      return "wall";
    case SegmentKind::kImageRegion:
      return "image region";
    case SegmentKind::kImageLine:
      return "image line";
  }
  return "unknown";
}

}  // namespace infuse::streetmap
