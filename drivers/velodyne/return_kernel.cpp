#include "drivers/velodyne/return_kernel.hpp"

#include "drivers/lidar/return_lanes.hpp"

namespace infuse::velodyne {
namespace {

using namespace lidar::lanes;

INFUSE_INLINE Floats absolute(const Floats& v) { return (Floats)((Ints)v & 0x7FFFFFFF); }
INFUSE_INLINE Floats larger(const Floats& a, const Floats& b) { return a < b ? b : a; }
INFUSE_INLINE Floats smaller(const Floats& a, const Floats& b) { return b < a ? b : a; }

/// Horizontal direction in the lidar sensor's vendor axes: y is forward, x right.
struct Direction {
  Floats forward, right;
};

INFUSE_INLINE Direction rotate_direction(const SequenceBlocks& sequence, const Floats& forward,
                                         const Floats& right) {
  return {sequence.cos_azimuth * forward - sequence.sin_azimuth * right,
          sequence.sin_azimuth * forward + sequence.cos_azimuth * right};
}

INFUSE_INLINE Returns decode_uniform(const BeamTable& table, size_t slot,
                                     const Direction& direction, const Ints& raw) {
  Returns r;
  r.range = to_floats(raw & 0xFFFF) * table.distance_unit;
  r.x = r.range * direction.forward;
  r.y = -(r.range * direction.right);
  r.z = r.range * load<Floats>(&table.sin_elevation[slot]) +
        load<Floats>(&table.vertical_offset[slot]);
  r.reflectivity = to_floats(raw >> 16) / 255.0F;
  return r;
}

/// Full correction of an HDL-64E: two-point correction of distance, offset origins, reflectivity
/// over focus.
INFUSE_INLINE Returns decode_corrected(const BeamTable& table, size_t slot,
                                       const Direction& direction, const Ints& raw) {
  const auto load_slots = [&](const BeamTable::PerSlot<float>& values) {
    return load<Floats>(&values[slot]);
  };
  const Floats units = to_floats(raw & 0xFFFF);
  const Floats distance = units * table.distance_unit;
  const Floats far = load_slots(table.far_correction);
  const Floats cos_elevation = load_slots(table.cos_elevation);
  const Floats horizontal = (distance + far) * cos_elevation;
  const Floats along_x = absolute(horizontal * direction.right);
  const Floats along_y = absolute(horizontal * direction.forward);
  const Floats near_x =
      load_slots(table.near_x) + load_slots(table.slope_x) * (along_x - kNearDistanceX);
  const Floats near_y =
      load_slots(table.near_y) + load_slots(table.slope_y) * (along_y - kNearDistanceY);
  const Ints is_near = distance < kFarDistance;
  const Floats correction_x = is_near ? near_x : far;
  const Floats correction_y = is_near ? near_y : far;

  Returns r;
  const Floats offset = load_slots(table.horizontal_offset);
  r.range = distance + far;
  r.x = (distance + correction_y) * cos_elevation * direction.forward + offset * direction.right;
  r.y = offset * direction.forward - (distance + correction_x) * cos_elevation * direction.right;
  r.z = (distance + (correction_x + correction_y) * 0.5F) * load_slots(table.sin_elevation) +
        load_slots(table.vertical_offset);

  const Floats defocus = 1.0F - units / 65535.0F;
  const Floats intensity =
      to_floats(raw >> 16) +
      load_slots(table.focal_slope) * absolute(load_slots(table.focal_term) - defocus * defocus);
  r.reflectivity =
      larger(smaller(intensity, load_slots(table.max_intensity)), load_slots(table.min_intensity)) /
      255.0F;
  return r;
}

template <bool kCorrected, bool kDual>
INFUSE_INLINE size_t decode_group(const BeamTable& table, const SequenceBlocks& sequence,
                                  EchoKinds kinds, size_t slot, const ReturnArrays& out, size_t n) {
  const uint8_t* bytes =
      sequence.returns + slot / kSlotsPerBlock * sequence.bank_stride + slot % kSlotsPerBlock * 3;
  const Direction direction =
      rotate_direction(sequence, load<Floats>(table.forward(sequence.step) + slot),
                       load<Floats>(table.right(sequence.step) + slot));
  const Group group{load<Ints>(&table.ring[slot]),
                    load<Ints>(&table.time_ns[slot]) + sequence.time_offset_ns,
                    static_cast<uint16_t>(sequence.column + slot / table.info->lasers)};
  const auto decode_lanes = [&](const Ints& raw) __attribute__((always_inline)) {
    return kCorrected ? decode_corrected(table, slot, direction, raw)
                      : decode_uniform(table, slot, direction, raw);
  };

  const Ints raw = load_returns(bytes);
  const Ints present = (raw & 0xFFFF) != 0;
  if constexpr (!kDual) {
    return append(decode_lanes(raw), group, kind_lanes(kinds.first), lane_set(present), out, n);
  } else {
    const Ints other = load_returns(bytes + sequence.echo_stride);
    const Ints same = raw == other;
    const Ints kind = same ? kind_lanes(ReturnKind::kBoth) : kind_lanes(kinds.first);
    n = append(decode_lanes(raw), group, kind, lane_set(present), out, n);
    const Ints other_present = ((other & 0xFFFF) != 0) & ~same;
    return append(decode_lanes(other), group, kind_lanes(kinds.second), lane_set(other_present),
                  out, n);
  }
}

template <bool kCorrected, bool kDual>
INFUSE_INLINE size_t decode_all(const BeamTable& table, std::span<const SequenceBlocks> sequences,
                                EchoKinds kinds, const ReturnArrays& arrays, size_t n) {
  const ReturnArrays out = arrays;
  const size_t slots = table.info->slots();
  for (const SequenceBlocks& sequence : sequences) {
    for (size_t slot = 0; slot < slots; slot += kLanes) {
      n = decode_group<kCorrected, kDual>(table, sequence, kinds, slot, out, n);
    }
  }
  return n;
}

struct Decode {
  INFUSE_INLINE static size_t run(const BeamTable& table, std::span<const SequenceBlocks> sequences,
                                  EchoKinds kinds, const ReturnArrays& out, size_t n) {
    const bool dual = !sequences.empty() && sequences.front().echo_stride != 0;
    if (table.info->calibrated_per_unit) {
      return dual ? decode_all<true, true>(table, sequences, kinds, out, n)
                  : decode_all<true, false>(table, sequences, kinds, out, n);
    }
    return dual ? decode_all<false, true>(table, sequences, kinds, out, n)
                : decode_all<false, false>(table, sequences, kinds, out, n);
  }
};

}  // namespace

ReturnKernel return_kernel(InstructionSet set) {
  return KernelVariants<Decode, ReturnKernel>::select(set);
}

}  // namespace infuse::velodyne
