#include "fusion/dependence/spline_kernels.hpp"

#include <algorithm>
#include <cstring>

#include "fusion/dependence/joint_histogram.hpp"

namespace infuse::dependence {
namespace {

constexpr size_t kLanes = 4;  // lanes of a Float4
using Int4 = int32_t __attribute__((vector_size(16)));

Float4 broadcast(float value) { return Float4{value, value, value, value}; }

/// Derivatives of the weights with respect to f; they sum to 0.
Float4 spline_slopes(float f) {
  // Of the uniform cubic B-spline, by definition.
  constexpr Float4 kSquare = {-0.5F, 1.5F, -1.5F, 0.5F}, kLinear = {1, -2, 1, 0},
                   kConstant = {-0.5F, 0, 0.5F, 0};
  const Float4 u = broadcast(f);
  return (kSquare * u + kLinear) * u + kConstant;
}

}  // namespace

Float4 spline_weights(float f) {
  // Of the uniform cubic B-spline, by definition.
  constexpr Float4 kCubic = {-1.0F / 6, 0.5F, -0.5F, 1.0F / 6}, kSquare = {0.5F, -1, 0.5F, 0},
                   kLinear = {-0.5F, 0, 0.5F, 0}, kConstant = {1.0F / 6, 4.0F / 6, 1.0F / 6, 0};
  const Float4 u = broadcast(f);
  return ((kCubic * u + kSquare) * u + kLinear) * u + kConstant;
}

SplineChunkStats locate_samples(const float* moving, const int32_t* first_block, size_t count,
                                const SplineAxis& axis, SplineChunk& chunk) {
  static_assert(kSplineChunkSize % kLanes == 0);
  const int32_t last = static_cast<int32_t>(axis.intervals) - 1;
  const Float4 low = Float4{} + axis.low, scale = Float4{} + axis.scale,
               intervals = Float4{} + axis.intervals;
  const Int4 absent_block = Int4{} + axis.absent_block;
  Int4 invalid{}, present{}, max_place = Int4{} - 1;
  Int4 min_place = Int4{} + std::numeric_limits<int32_t>::max();
  for (size_t i = 0; i < count; i += kLanes) {
    Float4 y = Float4{} + kAbsent;  // lanes beyond the end are absent
    Int4 first{};
    const size_t lanes = std::min(kLanes, count - i);
    if (lanes == kLanes) [[likely]] {
      std::memcpy(&y, moving + i, sizeof y);
      std::memcpy(&first, first_block + i, sizeof first);
    } else {
      std::memcpy(&y, moving + i, lanes * sizeof(float));
      std::memcpy(&first, first_block + i, lanes * sizeof(int32_t));
    }
    const Int4 absent = y == kAbsent;  // −1 if absent
    const Float4 t = (y - low) * scale;
    Float4 place = t > 0 ? t : Float4{};  // maps NaN to 0
    place = place < intervals ? place : intervals;
    Int4 interval = __builtin_convertvector(place, Int4);
    interval = interval < last ? interval : Int4{} + last;
    const Float4 fraction = place - __builtin_convertvector(interval, Float4);
    const Float4 inside = t == place ? Float4{} + 1 : Float4{};
    const Int4 block = absent ? absent_block : first + interval;
    std::memcpy(chunk.fraction + i, &fraction, sizeof fraction);
    std::memcpy(chunk.inside + i, &inside, sizeof inside);
    std::memcpy(chunk.block + i, &block, sizeof block);
    invalid -= ~(y > -kAbsent);
    present -= ~absent;
    Int4 bits;
    std::memcpy(&bits, &place, sizeof bits);
    const Int4 lesser = ~absent & (bits < min_place), greater = ~absent & (bits > max_place);
    min_place = lesser ? bits : min_place;
    max_place = greater ? bits : max_place;
  }
  SplineChunkStats stats;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    stats.invalid += invalid[lane];
    stats.present += present[lane];
    stats.min_place = std::min(stats.min_place, min_place[lane]);
    stats.max_place = std::max(stats.max_place, max_place[lane]);
  }
  return stats;
}

void add_to_blocks(const SplineChunk& chunk, const Float4* weights, size_t count, Float4* blocks) {
  for (size_t i = 0; i < count; ++i) {
    const Float4 x = weights[i], y = spline_weights(chunk.fraction[i]);
    Float4* block = blocks + 4 * static_cast<size_t>(chunk.block[i]);
    block[0] += broadcast(x[0]) * y;
    block[1] += broadcast(x[1]) * y;
    block[2] += broadcast(x[2]) * y;
    block[3] += broadcast(x[3]) * y;
  }
}

void differentiate_blocks(const SplineChunk& chunk, const Float4* weights, size_t count,
                          const Float4* blocks, float factor, float* gradient) {
  for (size_t i = 0; i < count; ++i) {
    const Float4 x = weights[i];
    const Float4* block = blocks + 4 * static_cast<size_t>(chunk.block[i]);
    const Float4 along_y = (broadcast(x[0]) * block[0] + broadcast(x[1]) * block[1]) +
                           (broadcast(x[2]) * block[2] + broadcast(x[3]) * block[3]);
    const Float4 terms = along_y * spline_slopes(chunk.fraction[i]);
    gradient[i] = ((terms[0] + terms[2]) + (terms[1] + terms[3])) * (chunk.inside[i] * factor);
  }
}

}  // namespace infuse::dependence
