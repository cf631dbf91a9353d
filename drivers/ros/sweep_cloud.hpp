#pragma once

#include <vector>

#include "drivers/measurement/sweep.hpp"
#include "drivers/ros/messages.hpp"

namespace infuse::ros {

/// Returns a sweep as a cloud of one row: x, y, z, intensity (float32: m, and 0 … 1), t (uint32: ns
/// after the header's stamp, which is the sweep's), ring and column (uint16), return_kind (uint8).
/// Without times there is no t. `data` receives the points, to which the cloud refers.
PointCloud2 to_cloud(const Sweep& sweep, const std::string& frame, std::vector<uint8_t>& data);

}  // namespace infuse::ros
