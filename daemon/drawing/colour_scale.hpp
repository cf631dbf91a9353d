#pragma once

#include <array>
#include <cstdint>

namespace infuse::daemon {

using Colour = std::array<uint8_t, 3>;  ///< blue, green, red

/// Colour of a distance (m) on viridis, bright near and dark far, logarithmic from 2 to 80 m; the
/// same as in the view (daemon/view/page/colours.js). Perceptually even, and readable by the
/// colour-blind (van der Walt and Smith, 2015).
Colour range_colour(double range);

/// Colour of a fraction 0 … 1 on cividis (Nuñez, Anderton and Renslow, 2018), without its darkest
/// tenth.
Colour fraction_colour(double fraction);

}  // namespace infuse::daemon
