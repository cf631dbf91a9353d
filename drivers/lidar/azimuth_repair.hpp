#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace infuse::lidar {

/// True if every azimuth of a packet follows the one before it by at most `max_step` (0.01°), the
/// first one `before`, as nearly always: then there is nothing to repair.
bool is_smooth(std::span<const uint16_t> azimuths, int before, int max_step);

/// Replaces azimuths that cannot be the sensor's by interpolation between their neighbours: those
/// above 360° (`kNoAzimuth`), and single ones that follow neither the sequence before nor lead to
/// the one after, while these two follow each other. `before` and `after` are the azimuths (0.01°)
/// of the sequences directly before and after the packet, if they are known; `max_step` is the
/// largest step of a rotation. Returns the number of azimuths replaced; afterwards all are in
/// 0 … 35999.
size_t repair_azimuths(std::span<uint16_t> azimuths, std::optional<int> before,
                       std::optional<int> after, int max_step);

}  // namespace infuse::lidar
