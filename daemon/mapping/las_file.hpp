#pragma once

#include <optional>
#include <string>

#include "daemon/mapping/map_projection.hpp"
#include "drivers/measurement/error.hpp"
#include "fusion/mapping/submap.hpp"

namespace infuse::daemon {

/// Formats a cloud as LAS 1.2, point format 0 (ASPRS, LAS Specification 1.2): millimetres, and
/// reflectivity as intensity, 65535 for 1. With an origin in UTM coordinates of its zone, which the
/// file names (EPSG 326xx, 327xx); without one in the frame of the map. Fails without points, with
/// more than 2^32 - 1, where a coordinate does not fit, and near the poles, where UTM ends.
Result<std::string> format_cloud_las(const mapping::Submap& cloud,
                                     const std::optional<MapOrigin>& origin);

}  // namespace infuse::daemon
