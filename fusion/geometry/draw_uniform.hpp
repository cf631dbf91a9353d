#pragma once

#include <random>

namespace infuse::geometry {

/// Draws evenly from [−1, 1); the standard's distributions differ between libraries.
inline double draw_uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}

}  // namespace infuse::geometry
