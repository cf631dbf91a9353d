#include "daemon/drawing/colour_scale.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace infuse::daemon {
namespace {

// Red, green, blue at equal steps of the scales.
constexpr std::array<Colour, 9> kViridis{{{68, 1, 84},
                                          {71, 44, 122},
                                          {59, 81, 139},
                                          {44, 113, 142},
                                          {33, 144, 141},
                                          {39, 173, 129},
                                          {92, 200, 99},
                                          {170, 220, 50},
                                          {253, 231, 37}}};
constexpr std::array<Colour, 10> kCividis{{{0, 32, 77},
                                           {0, 51, 111},
                                           {57, 72, 107},
                                           {87, 92, 109},
                                           {112, 113, 115},
                                           {138, 135, 121},
                                           {166, 157, 117},
                                           {196, 181, 108},
                                           {228, 207, 91},
                                           {255, 234, 70}}};
constexpr double kNearRange = 2, kFarRange = 80;  // m
constexpr double kDarkest = 0.1;                  // of a scale: darker is not seen on dark images

/// Colour at kDarkest … 1 of a scale, for `fraction` 0 … 1.
Colour colour_at(std::span<const Colour> scale, double fraction) {
  const double part = kDarkest + (1 - kDarkest) * std::clamp(fraction, 0.0, 1.0);
  const double at = part * static_cast<double>(scale.size() - 1);
  const size_t k = std::min(static_cast<size_t>(at), scale.size() - 2);
  const double u = at - static_cast<double>(k);
  Colour colour{};
  for (size_t c = 0; c < 3; ++c) {
    colour[2 - c] = static_cast<uint8_t>(std::lround((1 - u) * scale[k][c] + u * scale[k + 1][c]));
  }
  return colour;
}

}  // namespace

Colour range_colour(double range) {
  return colour_at(kViridis, 1 - std::log(range / kNearRange) / std::log(kFarRange / kNearRange));
}

Colour fraction_colour(double fraction) { return colour_at(kCividis, fraction); }

}  // namespace infuse::daemon
