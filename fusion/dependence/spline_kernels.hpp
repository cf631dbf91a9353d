#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace infuse::dependence {

/// Inner loops of a `SplineTile`. They use registers of four floats, which every x86-64 and every
/// 64-bit ARM has, so that one code gives the same bytes on all of them; wider registers gain only
/// a tenth of the time.

/// Four floats in one vector register.
using Float4 = float __attribute__((vector_size(16)));

/// Maximum number of samples per kernel call, whose places stay in the cache.
inline constexpr size_t kSplineChunkSize = 1024;

/// The y axis in knot intervals.
struct SplineAxis {
  float low, scale;      ///< position along the axis = (y − low) · scale
  float intervals;       ///< number of knot intervals, at least 1
  int32_t absent_block;  ///< block of absent samples
};

/// Positions of the samples of a chunk along y.
struct SplineChunk {
  alignas(64) int32_t block[kSplineChunkSize];
  alignas(64) float fraction[kSplineChunkSize];  ///< position within the knot interval, 0 … 1
  alignas(64) float inside[kSplineChunkSize];    ///< 1 if the sample has a derivative, else 0
};

/// Statistics of the samples of a chunk.
struct SplineChunkStats {
  int32_t present = 0, invalid = 0;  ///< numbers of samples; invalid: NaN or −∞
  /// Smallest and largest position of the present samples, as bits: floats ≥ 0 sort like their
  /// bits.
  int32_t min_place = std::numeric_limits<int32_t>::max(), max_place = -1;
};

/// Bins `count` moving samples; `first_block` is the begin of each sample's row of blocks.
SplineChunkStats locate_samples(const float* moving, const int32_t* first_block, size_t count,
                                const SplineAxis& axis, SplineChunk& chunk);

/// Adds the 4 × 4 products of each sample to its block of four rows.
void add_to_blocks(const SplineChunk& chunk, const Float4* weights, size_t count, Float4* blocks);

/// gradient_i = factor · Σ weights_k slopes_l block_kl.
void differentiate_blocks(const SplineChunk& chunk, const Float4* weights, size_t count,
                          const Float4* blocks, float factor, float* gradient);

/// Four cubic B-spline weights at the fraction f of a knot interval; they sum to 1.
Float4 spline_weights(float f);

}  // namespace infuse::dependence
