#include "drivers/ouster/return_kernel.hpp"

#include <cstring>

#include "drivers/lidar/return_lanes.hpp"

namespace infuse::ouster {
namespace {

using namespace lidar::lanes;

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
struct Beams {
  Floats direction_x, direction_y, direction_z;
  Floats origin_x, origin_y, origin_z;
  float beam_radius;
  Group group;
};

/// Appends the beams that have a return, and returns the new size.
INFUSE_INLINE size_t append_echo(const Beams& beams, const Echo& echo, const Ints& kind,
                                 const lidar::ReturnArrays& out, size_t n) {
  const Floats range = to_floats(echo.range) / 1000.0F;
  const Floats along = range - beams.beam_radius;
  const Returns returns{
      along * beams.direction_x + beams.origin_x, along * beams.direction_y + beams.origin_y,
      along * beams.direction_z + beams.origin_z, range, to_floats(echo.reflectivity) / 255.0F};
  return append(returns, beams.group, kind, lane_set(echo.range != 0), out, n);
}

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
INFUSE_INLINE size_t append_pixels(const Beams& beams, const uint8_t* pixels, const Kinds& kinds,
                                   const lidar::ReturnArrays& out, size_t n) {
  const Echo first = load_echo<kProfile, 0>(pixels);
  if constexpr (profile_info(kProfile).echoes == 1) {
    return append_echo(beams, first, kind_lanes(kinds.first_if_nearer), out, n);
  } else {
    const Echo second = load_echo<kProfile, 1>(pixels);
    const Ints farther = second.range > first.range;
    n = append_echo(beams, first,
                    farther ? kind_lanes(kinds.first_if_nearer) : kind_lanes(kinds.first), out, n);
    return append_echo(beams, second,
                       farther ? kind_lanes(kinds.second_if_farther) : kind_lanes(kinds.second),
                       out, n);
  }
}

template <Profile kProfile>
struct Decode {
  INFUSE_INLINE static size_t run(const BeamTable& table, std::span<const ColumnPixels> columns,
                                  FirstReturn first_return, const lidar::ReturnArrays& arrays,
                                  size_t n) {
    const lidar::ReturnArrays out = arrays;
    const Kinds kinds = kinds_of(first_return);
    for (const ColumnPixels& column : columns) {
      const size_t first = size_t{column.measurement_id} * table.beams;
      Beams beams{};
      beams.origin_x = Floats{} + table.origin_x[column.measurement_id];
      beams.origin_y = Floats{} + table.origin_y[column.measurement_id];
      beams.origin_z = Floats{} + table.origin_z[column.measurement_id];
      beams.beam_radius = table.beam_radius;
      beams.group.column = column.column;
      beams.group.time = Ints{} + column.time_offset_ns;
      for (size_t beam = 0; beam < table.beams; beam += kLanes) {
        beams.direction_x = load<Floats>(&table.direction_x[first + beam]);
        beams.direction_y = load<Floats>(&table.direction_y[first + beam]);
        beams.direction_z = load<Floats>(&table.direction_z[first + beam]);
        beams.group.ring = load<Ints>(&table.ring[beam]);
        const uint8_t* pixels = column.pixels + beam * profile_info(kProfile).pixel_bytes;
        n = append_pixels<kProfile>(beams, pixels, kinds, out, n);
      }
    }
    return n;
  }
};

template <Profile kProfile>
ReturnKernel select(InstructionSet set) {
  return KernelVariants<Decode<kProfile>, ReturnKernel>::select(set);
}

}  // namespace

ReturnKernel return_kernel(Profile profile, InstructionSet set) {
  switch (profile) {  // zones, windows and near-infrared are not read
    case Profile::kLegacy:
      return select<Profile::kLegacy>(set);
    case Profile::kRng19:
    case Profile::kRng19Zone:
      return select<Profile::kRng19>(set);
    case Profile::kRng19Dual:
    case Profile::kRng19ZoneDual:
      return select<Profile::kRng19Dual>(set);
    case Profile::kRng15:
    case Profile::kRng15Window:
      return select<Profile::kRng15>(set);
    case Profile::kRng15Zone:
      return select<Profile::kRng15Zone>(set);
    case Profile::kFusaDual:
    case Profile::kRng15Dual:
      break;
  }
  return select<Profile::kFusaDual>(set);
}

}  // namespace infuse::ouster
