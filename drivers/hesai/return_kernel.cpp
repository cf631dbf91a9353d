#include "drivers/hesai/return_kernel.hpp"

#include "drivers/lidar/return_lanes.hpp"

namespace infuse::hesai {
namespace {

using namespace lidar::lanes;

/// Loads the units of eight channels, each as distance + reflectivity · 65536.
template <size_t kUnitSize>
INFUSE_INLINE Ints load_units(const uint8_t* from) {
  if constexpr (kUnitSize == 3) return load_returns(from);
  return load<Ints>(from) & 0xFFFFFF;
}

/// Directions and times of eight channels of one firing.
struct Beams {
  Floats forward, left, up;
  Group group;
};

INFUSE_INLINE Beams turn_beams(const BeamTable& table, const Firing& firing, size_t channel) {
  const auto forward = load<Floats>(firing.row.forward + channel);
  const auto right = load<Floats>(firing.row.right + channel);
  return {firing.cos_azimuth * forward - firing.sin_azimuth * right,
          -(firing.sin_azimuth * forward + firing.cos_azimuth * right),
          load<Floats>(&table.sin_elevation()[channel]),
          {load<Ints>(&table.ring()[channel]),
           load<Ints>(firing.time_ns + channel) + firing.time_offset_ns, firing.column}};
}

INFUSE_INLINE Returns decode_units(const Beams& beams, float distance_unit, const Ints& raw) {
  Returns r;
  r.range = to_floats(raw & 0xFFFF) * distance_unit;
  r.x = r.range * beams.forward;
  r.y = r.range * beams.left;
  r.z = r.range * beams.up;
  r.reflectivity = to_floats(raw >> 16) / 255.0F;
  return r;
}

template <size_t kUnitSize, size_t kReturns>
INFUSE_INLINE size_t decode_group(const Beams& beams, const uint8_t* units,
                                  const UnitLayout& layout, const lidar::ReturnArrays& out,
                                  size_t n) {
  std::array<Ints, kReturns> raw;
  for (size_t i = 0; i < kReturns; ++i) {
    raw[i] = load_units<kUnitSize>(units + i * layout.block_size);
  }
  for (size_t i = 0; i < kReturns; ++i) {
    Ints present = (raw[i] & 0xFFFF) != 0;
    Ints kind = kind_lanes(layout.kinds[i]);
    for (size_t earlier = 0; earlier < i; ++earlier) present &= raw[i] != raw[earlier];
    for (size_t later = i + 1; later < kReturns; ++later) {
      kind = raw[i] == raw[later] ? kind_lanes(ReturnKind::kBoth) : kind;
    }
    n = append(decode_units(beams, layout.distance_unit, raw[i]), beams.group, kind,
               lane_set(present), out, n);
  }
  return n;
}

template <size_t kUnitSize, size_t kReturns>
INFUSE_INLINE size_t decode_firings(const BeamTable& table, std::span<const Firing> firings,
                                    const UnitLayout& layout, const lidar::ReturnArrays& arrays,
                                    size_t n) {
  const lidar::ReturnArrays out = arrays;
  const size_t channels = table.info().lasers;
  for (const Firing& firing : firings) {
    for (size_t channel = 0; channel < channels; channel += kLanes) {
      n = decode_group<kUnitSize, kReturns>(turn_beams(table, firing, channel),
                                            firing.units + channel * kUnitSize, layout, out, n);
    }
  }
  return n;
}

template <size_t kUnitSize>
INFUSE_INLINE size_t decode_returns(const BeamTable& table, std::span<const Firing> firings,
                                    const UnitLayout& layout, const lidar::ReturnArrays& out,
                                    size_t n) {
  switch (layout.returns) {
    case 1:
      return decode_firings<kUnitSize, 1>(table, firings, layout, out, n);
    case 2:
      return decode_firings<kUnitSize, 2>(table, firings, layout, out, n);
    default:
      return decode_firings<kUnitSize, 3>(table, firings, layout, out, n);
  }
}

struct Decode {
  INFUSE_INLINE static size_t run(const BeamTable& table, std::span<const Firing> firings,
                                  const UnitLayout& layout, const lidar::ReturnArrays& out,
                                  size_t n) {
    return layout.unit_size == 3 ? decode_returns<3>(table, firings, layout, out, n)
                                 : decode_returns<4>(table, firings, layout, out, n);
  }
};

}  // namespace

ReturnKernel return_kernel(InstructionSet set) {
  return KernelVariants<Decode, ReturnKernel>::select(set);
}

}  // namespace infuse::hesai
