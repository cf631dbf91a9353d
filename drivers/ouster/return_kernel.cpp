#include "drivers/ouster/return_kernel.hpp"

#include <array>
#include <bit>
#include <cstring>

// Eight beams at a time, in the compiler's portable vectors, so that the same source gives the same
// bytes with and without vector instructions.

#define INFUSE_INLINE [[gnu::always_inline]] inline

namespace infuse::ouster {
namespace {

constexpr size_t kLanes = 8;
using Floats = float __attribute__((vector_size(32)));
using Ints = int32_t __attribute__((vector_size(32)));
using Ints4 = int32_t __attribute__((vector_size(16)));
using Shorts = uint16_t __attribute__((vector_size(16)));
using Bytes = uint8_t __attribute__((vector_size(8)));

/// For each set of lanes: these lanes in order, moved to the front.
alignas(32) constexpr auto kLaneOrder = [] {
  std::array<std::array<int32_t, kLanes>, 256> table{};
  for (size_t set = 0; set < table.size(); ++set) {
    size_t n = 0;
    for (int32_t lane = 0; lane < static_cast<int32_t>(kLanes); ++lane) {
      if ((set >> lane & 1) != 0) table[set][n++] = lane;
    }
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

/// Bit i is set if lane i of a comparison is true.
INFUSE_INLINE size_t lane_set(const Ints& truth) {
  const Ints bits = truth & Ints{1, 2, 4, 8, 16, 32, 64, 128};
  const Ints4 halves = __builtin_shufflevector(bits, bits, 0, 1, 2, 3) |
                       __builtin_shufflevector(bits, bits, 4, 5, 6, 7);
  const Ints4 pairs = halves | __builtin_shufflevector(halves, halves, 2, 3, 2, 3);
  return static_cast<size_t>(pairs[0] | pairs[1]);
}

/// The words of 32 bits at `offset` of eight pixels.
template <size_t kStride>
INFUSE_INLINE Ints load_words(const uint8_t* pixels, size_t offset) {
  Ints words;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    int32_t word;
    std::memcpy(&word, pixels + lane * kStride + offset, sizeof word);
    words[lane] = word;
  }
  return words;
}

/// A field of eight pixels.
template <size_t kStride>
INFUSE_INLINE Ints load_field(const uint8_t* pixels, const PixelField& field) {
  // Of the aligned word that it lies in, since what follows the last pixel may not be readable.
  const Ints words = load_words<kStride>(pixels, field.offset & ~3u);
  const int32_t mask = static_cast<int32_t>((uint32_t{1} << field.bits) - 1);
  return ((words >> (field.offset % 4 * 8)) & mask) * field.unit;
}

/// Range in millimetres and reflectivity in 255ths.
struct Echo {
  Ints range, reflectivity;
};

template <Profile kProfile, size_t kEcho>
INFUSE_INLINE Echo load_echo(const uint8_t* pixels) {
  constexpr const ProfileInfo& info = profile_info(kProfile);
  constexpr const EchoFields& fields = info.echo[kEcho];
  const Ints reflectivity = load_field<info.pixel_bytes>(pixels, fields.reflectivity);
  return {load_field<info.pixel_bytes>(pixels, fields.range),
          reflectivity < 255 ? reflectivity : Ints{} + 255};
}

/// What eight beams of a column share apart from their echoes.
struct Group {
  Floats direction_x, direction_y, direction_z;
  Floats origin_x, origin_y, origin_z;
  float beam_radius;
  Ints ring;
  uint16_t column;
  int32_t time_offset_ns;
};

/// Appends the lanes that have a return, and returns the new size.
INFUSE_INLINE size_t append(const Group& group, const Echo& echo, const Ints& kind,
                            const lidar::ReturnArrays& out, size_t n) {
  const Floats range = to_floats(echo.range) / 1000.0F;
  const Floats along = range - group.beam_radius;
  const size_t set = lane_set(echo.range != 0);
  const Ints order = load<Ints>(kLaneOrder[set].data());
  store(out.x + n, permute(along * group.direction_x + group.origin_x, order));
  store(out.y + n, permute(along * group.direction_y + group.origin_y, order));
  store(out.z + n, permute(along * group.direction_z + group.origin_z, order));
  store(out.range + n, permute(range, order));
  store(out.reflectivity + n, permute(to_floats(echo.reflectivity) / 255.0F, order));
  store(out.ring + n, __builtin_convertvector(permute(group.ring, order), Shorts));
  store(out.column + n, Shorts{} + group.column);
  store(out.time_offset_ns + n, Ints{} + group.time_offset_ns);
  store(out.return_kind + n, __builtin_convertvector(permute(kind, order), Bytes));
  return n + static_cast<size_t>(std::popcount(set));
}

INFUSE_INLINE Ints kind_lanes(ReturnKind kind) { return Ints{} + static_cast<int32_t>(kind); }

/// Kinds of a pixel's returns, by whether the second one is the farther.
struct Kinds {
  ReturnKind first, second, first_if_nearer, second_if_farther;
};

INFUSE_INLINE Kinds kinds_of(FirstReturn first_return) {
  using enum ReturnKind;
  switch (first_return) {
    case FirstReturn::kFarthest:
      return {kLast, kFirst, kLast, kFirst};
    case FirstReturn::kNearest:
      return {kFirst, kSecond, kFirst, kSecond};
    case FirstReturn::kStrongest:
      break;
  }
  return {kBoth, kSecondStrongest, kStrongest, kLast};
}

/// Appends the echoes of eight pixels.
template <Profile kProfile>
INFUSE_INLINE size_t decode_group(const Group& group, const uint8_t* pixels, const Kinds& kinds,
                                  const lidar::ReturnArrays& out, size_t n) {
  const Echo first = load_echo<kProfile, 0>(pixels);
  if constexpr (profile_info(kProfile).echoes == 1) {
    return append(group, first, kind_lanes(kinds.first_if_nearer), out, n);
  } else {
    const Echo second = load_echo<kProfile, 1>(pixels);
    const Ints farther = second.range > first.range;
    n = append(group, first, farther ? kind_lanes(kinds.first_if_nearer) : kind_lanes(kinds.first),
               out, n);
    return append(group, second,
                  farther ? kind_lanes(kinds.second_if_farther) : kind_lanes(kinds.second), out, n);
  }
}

template <Profile kProfile>
INFUSE_INLINE size_t decode(const BeamTable& table, std::span<const ColumnPixels> columns,
                            FirstReturn first_return, const lidar::ReturnArrays& arrays, size_t n) {
  const lidar::ReturnArrays out = arrays;
  const Kinds kinds = kinds_of(first_return);
  constexpr size_t pixel_bytes = profile_info(kProfile).pixel_bytes;
  for (const ColumnPixels& column : columns) {
    const size_t first = size_t{column.measurement_id} * table.beams;
    Group group{};
    group.origin_x = Floats{} + table.origin_x[column.measurement_id];
    group.origin_y = Floats{} + table.origin_y[column.measurement_id];
    group.origin_z = Floats{} + table.origin_z[column.measurement_id];
    group.beam_radius = table.beam_radius;
    group.column = column.column;
    group.time_offset_ns = column.time_offset_ns;
    for (size_t beam = 0; beam < table.beams; beam += kLanes) {
      group.direction_x = load<Floats>(&table.direction_x[first + beam]);
      group.direction_y = load<Floats>(&table.direction_y[first + beam]);
      group.direction_z = load<Floats>(&table.direction_z[first + beam]);
      group.ring = load<Ints>(&table.ring[beam]);
      n = decode_group<kProfile>(group, column.pixels + beam * pixel_bytes, kinds, out, n);
    }
  }
  return n;
}

template <Profile kProfile>
size_t decode_baseline(const BeamTable& table, std::span<const ColumnPixels> columns,
                       FirstReturn first_return, const lidar::ReturnArrays& out, size_t n) {
  return decode<kProfile>(table, columns, first_return, out, n);
}

#ifdef __x86_64__
template <Profile kProfile>
[[gnu::target("avx2")]] size_t decode_avx2(const BeamTable& table,
                                           std::span<const ColumnPixels> columns,
                                           FirstReturn first_return, const lidar::ReturnArrays& out,
                                           size_t n) {
  return decode<kProfile>(table, columns, first_return, out, n);
}
#endif

template <Profile kProfile>
ReturnKernel select(InstructionSet set) {
#ifdef __x86_64__
  return select_variant(set, decode_baseline<kProfile>, decode_avx2<kProfile>,
                        decode_avx2<kProfile>);
#else
  return select_variant(set, decode_baseline<kProfile>, decode_baseline<kProfile>,
                        decode_baseline<kProfile>);
#endif
}

}  // namespace

ReturnKernel return_kernel(Profile profile, InstructionSet set) {
  switch (profile) {
    case Profile::kLegacy:
      return select<Profile::kLegacy>(set);
    case Profile::kRng19:
      return select<Profile::kRng19>(set);
    case Profile::kRng19Dual:
      return select<Profile::kRng19Dual>(set);
    case Profile::kRng15:
      return select<Profile::kRng15>(set);
    case Profile::kFusaDual:
      break;
  }
  return select<Profile::kFusaDual>(set);
}

}  // namespace infuse::ouster
