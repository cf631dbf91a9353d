#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "fusion/streetmap/street_grid.hpp"

namespace infuse::streetmap {

/// Directions within half a turn (decision 17).
inline constexpr size_t kStreetDirections = 16;

/// Calls `found(direction, yaw)` for each direction in which a street leads through a point of it,
/// within half a turn: with more free street ahead and behind than the directions beside it.
template <class Found>
void for_street_directions(const StreetGrid& grid, const Eigen::Vector2d& p, Found found) {
  constexpr double kReach = 12;          // m, of free street ahead and behind (decision 17)
  constexpr double kMinFreeLength = 14;  // m, ahead and behind together (decision 17)
  constexpr double kStep = std::numbers::pi / kStreetDirections;
  std::array<double, kStreetDirections> lengths{};
  for (size_t i = 0; i < kStreetDirections; ++i) {
    const double yaw = static_cast<double>(i) * kStep;
    lengths[i] = grid.free_length({p.x(), p.y(), yaw}, kReach) +
                 grid.free_length({p.x(), p.y(), yaw + std::numbers::pi}, kReach);
  }
  for (size_t i = 0; i < kStreetDirections; ++i) {
    const double before = lengths[(i + kStreetDirections - 1) % kStreetDirections];
    const double after = lengths[(i + 1) % kStreetDirections];
    if (lengths[i] < kMinFreeLength || lengths[i] < before || lengths[i] <= after) continue;
    found(i, static_cast<double>(i) * kStep);
  }
}

}  // namespace infuse::streetmap
