#pragma once

#include <optional>
#include <vector>

#include "drivers/osm/openstreetmap.hpp"
#include "fusion/streetmap/street_plan.hpp"

namespace infuse::daemon {

/// Plan made from OpenStreetMap data, and defects of these data.
struct OsmStreetPlan {
  streetmap::StreetPlan plan;
  size_t carriageway_count = 0;  ///< number of ways that became carriageways
  std::vector<Error> warnings;   ///< each with an element id; those of the reader come first
};

/// Converts OpenStreetMap elements to strips and areas in metres. The width of a carriageway is its
/// `width` tag, else follows from its lanes, else is the usual one of its class (table in the .cpp,
/// after the German guidelines RASt 06 and RAL). Skipped with a warning: rings that are open or
/// cross themselves, and elements more than 50 km from the median of the map. Skipped without:
/// what lies outside `clip`, or, without it, outside the bounds that the file states, of which the
/// middle is the origin. Bounds of a file without a road in them are not used.
OsmStreetPlan build_street_plan(const osm::OpenStreetMap& map,
                                const std::optional<osm::Bounds>& clip = std::nullopt);

}  // namespace infuse::daemon
