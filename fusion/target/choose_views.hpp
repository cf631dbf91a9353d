#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fusion/target/find_boards.hpp"

namespace infuse::target {

/// Chooses views that differ: beginning with the first, always the one whose corners are farthest
/// from those of the views chosen before, until there are `max_views` or the next one is within
/// `min_motion` (px, root mean square of its corners). Returns their indices, ascending. A board
/// that is symmetric under a half turn may be found from either end. All views have equally many
/// corners.
std::vector<size_t> choose_views(std::span<const Corners> views, size_t max_views,
                                 double min_motion);

}  // namespace infuse::target
