#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace infuse::dependence {

/// The inner loops of a `SplineTile`. They are written for registers of four floats, which every
/// x86-64 and every 64-bit ARM has, so that one code gives the same bytes on all of them; wider
/// registers were measured and gain a tenth.

/// Four floats that live in one vector register.
using Float4 = float __attribute__((vector_size(16)));

/// How many samples the kernels take at once, at most.
inline constexpr size_t kSplineChunkSize = 1024;

/// The y axis in knot intervals.
struct SplineAxis {
  float low, scale;      ///< place along the axis = (y − low) · scale
  float intervals;       ///< a whole number, at least 1
  int32_t absent_block;  ///< block of samples that take no part
};

/// Where the samples of a chunk lie along y.
struct SplineChunk {
  alignas(64) int32_t block[kSplineChunkSize];
  alignas(64) float fraction[kSplineChunkSize];  ///< of the knot interval, 0 … 1
  alignas(64) float inside[kSplineChunkSize];    ///< 1 where the sample moves the table, else 0
};

/// What the samples of a chunk are like.
struct SplineChunkStats {
  int32_t present = 0, invalid = 0;  ///< counts; bad: not a number or −∞
  /// Least and greatest place along y of those present, as bits: a float ≥ 0 sorts like them.
  int32_t min_place = std::numeric_limits<int32_t>::max(), max_place = -1;
};

/// Bins `count` moving samples; `first_block` is where each one's row of blocks begins.
SplineChunkStats locate_samples(const float* moving, const int32_t* first_block, size_t count,
                                const SplineAxis& axis, SplineChunk& chunk);

/// Adds each sample's 4 × 4 products to its block of four rows.
void add_to_blocks(const SplineChunk& chunk, const Float4* weights, size_t count, Float4* blocks);

/// gradient_i = factor · Σ weights_k slopes_l block_kl.
void differentiate_blocks(const SplineChunk& chunk, const Float4* weights, size_t count,
                          const Float4* blocks, float factor, float* gradient);

/// The four cubic B-spline weights at the fraction f of a knot interval; they sum to 1.
Float4 spline_weights(float f);

}  // namespace infuse::dependence
