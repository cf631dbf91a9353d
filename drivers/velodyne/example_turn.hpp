#pragma once

#include <cstdint>
#include <vector>

#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {

/// Returns the payload of the data packet `index` of a model of one bank, one return, that turns
/// ten times a second in the middle of a cylinder of this radius, m.
std::vector<uint8_t> example_packet(const ModelInfo& info, uint32_t index, double radius);

}  // namespace infuse::velodyne
