#include "drivers/robosense/return_kernel.hpp"

#include "drivers/lidar/return_lanes.hpp"
#include "drivers/robosense/packet.hpp"

namespace infuse::robosense {
namespace {

using namespace lidar::lanes;

/// Directions, origins and times of eight channels of one firing.
struct Beams {
  Floats forward, left, up, origin_forward, origin_left;
  Group group;
};

INFUSE_INLINE Beams turn_beams(const BeamTable& table, const Firing& firing, size_t slot) {
  const auto forward = load<Floats>(firing.row.forward + slot);
  const auto right = load<Floats>(firing.row.right + slot);
  const auto origin_forward = load<Floats>(firing.row.origin_forward + slot);
  const auto origin_right = load<Floats>(firing.row.origin_right + slot);
  return {firing.cos_azimuth * forward - firing.sin_azimuth * right,
          -(firing.sin_azimuth * forward + firing.cos_azimuth * right),
          load<Floats>(&table.sin_elevation()[slot]),
          firing.cos_azimuth * origin_forward - firing.sin_azimuth * origin_right,
          -(firing.sin_azimuth * origin_forward + firing.cos_azimuth * origin_right),
          {load<Ints>(&table.ring()[slot]),
           load<Ints>(&table.time_ns()[slot]) + firing.time_offset_ns, firing.column}};
}

/// `raw`: the two bytes of a distance as on the wire, the high one first, and the reflectivity.
INFUSE_INLINE Returns decode_units(const Beams& beams, float distance_unit, const Ints& raw) {
  Returns r;
  r.range = to_floats((raw & 0xFF) << 8 | (raw >> 8 & 0xFF)) * distance_unit;
  r.x = r.range * beams.forward + beams.origin_forward;
  r.y = r.range * beams.left + beams.origin_left;
  r.z = r.range * beams.up;
  r.reflectivity = to_floats(raw >> 16) / 255.0F;
  return r;
}

INFUSE_INLINE size_t append_units(const Beams& beams, const UnitLayout& layout, const Ints& raw,
                                  const Ints& kind, const Ints& wanted,
                                  const lidar::ReturnArrays& out, size_t n) {
  const Ints present = wanted & ((raw & 0xFFFF) != 0);
  return append(decode_units(beams, layout.distance_unit, raw), beams.group, kind,
                lane_set(present), out, n);
}

template <bool kDual>
INFUSE_INLINE size_t decode_group(const Beams& beams, const uint8_t* units,
                                  const UnitLayout& layout, const lidar::ReturnArrays& out,
                                  size_t n) {
  const Ints all = Ints{} == 0;
  const Ints first = load_returns(units);
  const Ints kind = kind_lanes(layout.kinds[0]);
  if constexpr (!kDual) return append_units(beams, layout, first, kind, all, out, n);
  const Ints second = load_returns(units + layout.return_stride);
  const Ints equal = first == second;
  n = append_units(beams, layout, first, equal ? kind_lanes(ReturnKind::kBoth) : kind, all, out, n);
  return append_units(beams, layout, second, kind_lanes(layout.kinds[1]), first != second, out, n);
}

template <bool kDual>
INFUSE_INLINE size_t decode_firings(const BeamTable& table, std::span<const Firing> firings,
                                    const UnitLayout& layout, const lidar::ReturnArrays& arrays,
                                    size_t n) {
  const lidar::ReturnArrays out = arrays;
  const size_t channels = table.info().lasers;
  for (const Firing& firing : firings) {
    for (size_t channel = 0; channel < channels; channel += kLanes) {
      n = decode_group<kDual>(turn_beams(table, firing, firing.slot + channel),
                              firing.units + channel * kUnitSize, layout, out, n);
    }
  }
  return n;
}

struct Decode {
  INFUSE_INLINE static size_t run(const BeamTable& table, std::span<const Firing> firings,
                                  const UnitLayout& layout, const lidar::ReturnArrays& out,
                                  size_t n) {
    return layout.returns == 1 ? decode_firings<false>(table, firings, layout, out, n)
                               : decode_firings<true>(table, firings, layout, out, n);
  }
};

}  // namespace

ReturnKernel return_kernel(InstructionSet set) {
  return KernelVariants<Decode, ReturnKernel>::select(set);
}

}  // namespace infuse::robosense
