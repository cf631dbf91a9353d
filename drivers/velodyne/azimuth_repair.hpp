#pragma once

#include <cstddef>
#include <optional>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {

/// Replaces azimuths that cannot be the sensor's by interpolation between their neighbours: those
/// above 360° (`kNoAzimuth`), and single ones that follow neither the sequence before nor lead to
/// the one after, while these two follow each other. `before` and `after` are the azimuths (0.01°)
/// of the sequences directly before and after the packet, if they are known; `max_step` is the
/// largest step of a rotation. Returns the number of azimuths replaced; afterwards all are in
/// 0 … 35999.
size_t repair_azimuths(Packet& packet, std::optional<int> before, std::optional<int> after,
                       int max_step);

}  // namespace infuse::velodyne
