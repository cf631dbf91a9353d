#pragma once

#include <cstdint>
#include <vector>

namespace infuse::robosense {

/// The data packet `index` of an RS-Helios that turns ten times a second and measures this range,
/// m, in all directions; for the self-test of a release.
std::vector<uint8_t> example_packet(uint32_t index, double range);

}  // namespace infuse::robosense
