#pragma once

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
