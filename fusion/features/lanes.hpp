#pragma once

#include <cstdint>

namespace infuse::features {

/// Numbers processed side by side, in GCC's vector types. There are always 16 floats or 8 doubles,
/// whatever the processor's registers hold, so that sums across lanes are added in one order and
/// every instruction set gives the same bytes.
inline constexpr int kLanes = 16;
using Floats [[gnu::vector_size(64)]] = float;
using Ints [[gnu::vector_size(64)]] = int32_t;
using Flags [[gnu::vector_size(64)]] = int32_t;  ///< results of comparisons: -1 or 0
using Doubles [[gnu::vector_size(64)]] = double;

}  // namespace infuse::features
