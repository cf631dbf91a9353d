#pragma once

#include <array>
#include <cstdint>

#include "drivers/velodyne/packet.hpp"

namespace infuse::daemon {

/// Microseconds from one packet of `generated_packet` to the next.
inline constexpr double kGeneratedPacketUs = 24 * 55.296;

/// Returns the payload of the data packet `index` of a VLP-16 that turns ten times a second in the
/// middle of a cylinder of this radius, m.
std::array<uint8_t, velodyne::kPacketSize> generated_packet(uint32_t index, double radius);

}  // namespace infuse::daemon
