#pragma once

#include <vector>

#include "drivers/osm/openstreetmap.hpp"

namespace infuse::osm {

/// Joins ways end to end into closed rings (the first point is repeated at the end), reversing ways
/// if needed. Returns the number of rings that do not close; these are ignored.
size_t join_rings(const std::vector<const Way*>& ways, std::vector<std::vector<Point>>& rings);

}  // namespace infuse::osm
