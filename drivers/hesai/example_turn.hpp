#pragma once

#include <cstdint>
#include <vector>

#include "drivers/hesai/model.hpp"

namespace infuse::hesai {

/// The data packet `index` of an XT16 or XT32 that turns ten times a second and measures this
/// range, m, in all directions; for the self-test of a release.
std::vector<uint8_t> example_packet(const ModelInfo& info, uint32_t index, double range);

}  // namespace infuse::hesai
