#pragma once

#include <vector>

#include "drivers/osm/openstreetmap.hpp"

namespace infuse::recording {

/// Joins ways end to end into closed rings (first point repeated at the end), turning ways round
/// where needed. Gives the number of rings that do not close; these are left out.
size_t join_rings(const std::vector<const OsmWay*>& ways,
                  std::vector<std::vector<OsmPoint>>& rings);

}  // namespace infuse::recording
