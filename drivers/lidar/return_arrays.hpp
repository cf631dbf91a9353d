#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "drivers/measurement/sweep.hpp"

namespace infuse::lidar {

/// Number of entries that a decoder may write beyond the last return.
inline constexpr size_t kReturnSlack = 8;

/// One return, as an entry of a sweep.
struct Return {
  float x = 0, y = 0, z = 0;  ///< m, lidar frame
  float range = 0;            ///< m
  float reflectivity = 0;     ///< 0 … 1
  uint16_t ring = 0, column = 0;
  int32_t time_offset_ns = 0;
  ReturnKind return_kind = ReturnKind::kStrongest;
};

/// Coordinates and range of a return of a beam through the origin: azimuth (rad, clockwise) and
/// elevation (rad). For decoders that are simple rather than fast.
inline Return polar_return(double range, double azimuth, double elevation) {
  const double flat = range * std::cos(elevation);
  return {.x = static_cast<float>(flat * std::cos(azimuth)),
          .y = static_cast<float>(-flat * std::sin(azimuth)),
          .z = static_cast<float>(range * std::sin(elevation)),
          .range = static_cast<float>(range)};
}

/// The arrays of a sweep, with room for `kReturnSlack` returns beyond the last.
struct ReturnArrays {
  float *x, *y, *z, *range, *reflectivity;
  uint16_t *ring, *column;
  int32_t* time_offset_ns;
  ReturnKind* return_kind;

  /// Writes entry `i`.
  void set(size_t i, const Return& value) const {
    x[i] = value.x;
    y[i] = value.y;
    z[i] = value.z;
    range[i] = value.range;
    reflectivity[i] = value.reflectivity;
    ring[i] = value.ring;
    column[i] = value.column;
    time_offset_ns[i] = value.time_offset_ns;
    return_kind[i] = value.return_kind;
  }
};

}  // namespace infuse::lidar
