#pragma once

#include <vector>

#include "drivers/osm/openstreetmap.hpp"
#include "fusion/streetmap/street_plan.hpp"

namespace infuse::daemon {

/// A plan made of a map, and what of the map is not as it should be.
struct OsmStreetPlan {
  streetmap::StreetPlan plan;
  size_t carriageway_count = 0;  ///< ways that became one
  std::vector<Error> warnings;   ///< each with the element's id; the map's own come first
};

/// Turns OpenStreetMap's elements into strips and areas in metres. Carriageways are as wide as
/// their `width` says, else as their lanes need, else as is usual for their class (street_widths
/// in the .cpp, after the German guidelines RASt 06 and RAL). Left out, with a warning: rings that
/// are open or cross themselves, and elements that lie more than 50 km from the map's median.
OsmStreetPlan build_street_plan(const recording::OpenStreetMap& map);

}  // namespace infuse::daemon
