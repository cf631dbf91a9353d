#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "drivers/lidar/return_arrays.hpp"

// What kernels that decode eight returns at a time share, in the compiler's portable vectors, so
// that the same source gives the same bytes with and without vector instructions.

#define INFUSE_INLINE [[gnu::always_inline]] inline

namespace infuse::lidar::lanes {

constexpr size_t kLanes = 8;
using Floats = float __attribute__((vector_size(32)));
using Ints = int32_t __attribute__((vector_size(32)));
using Shorts = uint16_t __attribute__((vector_size(16)));
using Bytes = uint8_t __attribute__((vector_size(8)));
using Bytes16 = uint8_t __attribute__((vector_size(16)));
using Ints4 = int32_t __attribute__((vector_size(16)));

/// For each set of lanes: these lanes in order, moved to the front.
alignas(32) constexpr auto kCompactionOrder = [] {
  std::array<std::array<int32_t, kLanes>, 256> table{};
  for (size_t set = 0; set < table.size(); ++set) {
    size_t n = 0;
    for (int32_t lane = 0; lane < static_cast<int32_t>(kLanes); ++lane) {
      if ((set >> lane & 1) != 0) table[set][n++] = lane;
    }
  }
  return table;
}();

constexpr auto kLanesInSet = [] {
  std::array<uint8_t, 256> table{};
  for (size_t set = 0; set < table.size(); ++set) {
    table[set] = static_cast<uint8_t>(std::popcount(set));
  }
  return table;
}();

template <class Vector, class T>
INFUSE_INLINE Vector load(const T* from) {
  Vector vector;
  std::memcpy(&vector, from, sizeof vector);
  return vector;
}

template <class Vector, class T>
INFUSE_INLINE void store(T* to, const Vector& vector) {
  std::memcpy(to, &vector, sizeof vector);
}

INFUSE_INLINE Floats to_floats(const Ints& v) { return __builtin_convertvector(v, Floats); }

/// Loads eight returns of three bytes, each as distance + reflectivity · 65536. Reads these 24
/// bytes only.
INFUSE_INLINE Ints load_returns(const uint8_t* from) {
  const Bytes16 zero{};
  const Bytes16 low = __builtin_shufflevector(load<Bytes16>(from), zero, 0, 1, 2, 16, 3, 4, 5, 16,
                                              6, 7, 8, 16, 9, 10, 11, 16);
  const Bytes16 high = __builtin_shufflevector(load<Bytes16>(from + 8), zero, 4, 5, 6, 16, 7, 8, 9,
                                               16, 10, 11, 12, 16, 13, 14, 15, 16);
  return __builtin_shufflevector((Ints4)low, (Ints4)high, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// Bit i is set if lane i of a comparison is true.
INFUSE_INLINE size_t lane_set(const Ints& truth) {
  const Ints bits = truth & Ints{1, 2, 4, 8, 16, 32, 64, 128};
  const Ints4 halves = __builtin_shufflevector(bits, bits, 0, 1, 2, 3) |
                       __builtin_shufflevector(bits, bits, 4, 5, 6, 7);
  const Ints4 pairs = halves | __builtin_shufflevector(halves, halves, 2, 3, 2, 3);
  return static_cast<size_t>(pairs[0] | pairs[1]);
}

/// The low bytes of eight lanes.
INFUSE_INLINE Bytes low_bytes(const Ints& v) {
  const Shorts words = __builtin_convertvector(v, Shorts);
  const Bytes16 bytes = (Bytes16)words;
  const Bytes16 low =
      __builtin_shufflevector(bytes, bytes, 0, 2, 4, 6, 8, 10, 12, 14, 0, 2, 4, 6, 8, 10, 12, 14);
  Bytes result;
  std::memcpy(&result, &low, sizeof result);
  return result;
}

template <class Vector>
INFUSE_INLINE Vector permute(const Vector& v, const Ints& order) {
#ifdef __clang__
  Vector result;
  for (size_t lane = 0; lane < kLanes; ++lane) result[lane] = v[order[lane]];
  return result;
#else
  return __builtin_shuffle(v, order);
#endif
}

/// Eight decoded returns.
struct Returns {
  Floats x, y, z, range, reflectivity;
};

/// Data that eight lanes share apart from their returns.
struct Group {
  Ints ring, time;
  uint16_t column;
};

/// Appends the lanes of `set` to the arrays and returns the new size.
INFUSE_INLINE size_t append(const Returns& r, const Group& group, const Ints& kind, size_t set,
                            const ReturnArrays& out, size_t n) {
  const Ints order = load<Ints>(kCompactionOrder[set].data());
  store(out.x + n, permute(r.x, order));
  store(out.y + n, permute(r.y, order));
  store(out.z + n, permute(r.z, order));
  store(out.range + n, permute(r.range, order));
  store(out.reflectivity + n, permute(r.reflectivity, order));
  store(out.ring + n, __builtin_convertvector(permute(group.ring, order), Shorts));
  store(out.column + n, Shorts{} + group.column);
  store(out.time_offset_ns + n, permute(group.time, order));
  store(out.return_kind + n, low_bytes(permute(kind, order)));
  return n + kLanesInSet[set];
}

INFUSE_INLINE Ints kind_lanes(ReturnKind kind) { return Ints{} + static_cast<int32_t>(kind); }

}  // namespace infuse::lidar::lanes
