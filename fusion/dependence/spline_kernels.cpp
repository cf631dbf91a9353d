#include "fusion/dependence/spline_kernels.hpp"

#include <algorithm>
#include <bit>

#include "fusion/dependence/joint_histogram.hpp"

namespace infuse::dependence {
namespace {

#define INFUSE_INLINE [[gnu::always_inline]] inline

INFUSE_INLINE Float4 broadcast(float value) { return Float4{value, value, value, value}; }

INFUSE_INLINE Float4 weights_at(float f) {
  constexpr Float4 c3 = {-1.0F / 6, 0.5F, -0.5F, 1.0F / 6}, c2 = {0.5F, -1, 0.5F, 0},
                   c1 = {-0.5F, 0, 0.5F, 0}, c0 = {1.0F / 6, 4.0F / 6, 1.0F / 6, 0};
  const Float4 u = broadcast(f);
  return ((c3 * u + c2) * u + c1) * u + c0;
}

/// Derivatives of the weights with respect to f; they sum to 0.
INFUSE_INLINE Float4 slopes_at(float f) {
  constexpr Float4 c2 = {-0.5F, 1.5F, -1.5F, 0.5F}, c1 = {1, -2, 1, 0}, c0 = {-0.5F, 0, 0.5F, 0};
  const Float4 u = broadcast(f);
  return (c2 * u + c1) * u + c0;
}

INFUSE_INLINE SplineSeen locate(const float* moving, const int32_t* first_block, size_t count,
                                const SplineAxis& axis, SplineChunk& chunk) {
  const SplineAxis a = axis;
  const auto last = static_cast<int32_t>(a.intervals) - 1;
  SplineSeen seen;
  for (size_t i = 0; i < count; ++i) {
    const float y = moving[i];
    const bool absent = y == kAbsent;
    const float t = (y - a.low) * a.scale;
    float place = t > 0 ? t : 0;  // takes NaN to 0
    place = place < a.intervals ? place : a.intervals;
    const int32_t interval = std::min(static_cast<int32_t>(place), last);
    chunk.fraction[i] = place - static_cast<float>(interval);
    chunk.inside[i] = t == place ? 1.0F : 0.0F;
    chunk.block[i] = absent ? a.absent_block : first_block[i] + interval;
    seen.bad += static_cast<int32_t>(!(y > -kAbsent));
    seen.present += static_cast<int32_t>(!absent);
    const auto bits = std::bit_cast<int32_t>(place);
    seen.least = std::min(seen.least, absent ? seen.least : bits);
    seen.greatest = std::max(seen.greatest, absent ? seen.greatest : bits);
  }
  return seen;
}

INFUSE_INLINE void add(const SplineChunk& chunk, const Float4* weights, size_t count,
                       Float4* blocks) {
  for (size_t i = 0; i < count; ++i) {
    const Float4 x = weights[i], y = weights_at(chunk.fraction[i]);
    Float4* block = blocks + 4 * static_cast<size_t>(chunk.block[i]);
    block[0] += broadcast(x[0]) * y;
    block[1] += broadcast(x[1]) * y;
    block[2] += broadcast(x[2]) * y;
    block[3] += broadcast(x[3]) * y;
  }
}

INFUSE_INLINE void differentiate(const SplineChunk& chunk, const Float4* weights, size_t count,
                                 const Float4* blocks, float factor, float* gradient) {
  for (size_t i = 0; i < count; ++i) {
    const Float4 x = weights[i];
    const Float4* block = blocks + 4 * static_cast<size_t>(chunk.block[i]);
    const Float4 along_y = (broadcast(x[0]) * block[0] + broadcast(x[1]) * block[1]) +
                           (broadcast(x[2]) * block[2] + broadcast(x[3]) * block[3]);
    const Float4 terms = along_y * slopes_at(chunk.fraction[i]);
    gradient[i] = ((terms[0] + terms[2]) + (terms[1] + terms[3])) * (chunk.inside[i] * factor);
  }
}

#define INFUSE_VARIANT(NAME, ATTRIBUTE)                                                       \
  ATTRIBUTE SplineSeen locate_##NAME(const float* moving, const int32_t* first, size_t count, \
                                     const SplineAxis& axis, SplineChunk& chunk) {            \
    return locate(moving, first, count, axis, chunk);                                         \
  }                                                                                           \
  ATTRIBUTE void add_##NAME(const SplineChunk& chunk, const Float4* weights, size_t count,    \
                            Float4* blocks) {                                                 \
    add(chunk, weights, count, blocks);                                                       \
  }                                                                                           \
  ATTRIBUTE void differentiate_##NAME(const SplineChunk& chunk, const Float4* weights,        \
                                      size_t count, const Float4* blocks, float factor,       \
                                      float* gradient) {                                      \
    differentiate(chunk, weights, count, blocks, factor, gradient);                           \
  }                                                                                           \
  constexpr SplineKernels kKernels_##NAME = {locate_##NAME, add_##NAME, differentiate_##NAME};

INFUSE_VARIANT(baseline, )
INFUSE_VARIANT(avx2, [[gnu::target("avx2")]])
INFUSE_VARIANT(avx512, [[gnu::target("arch=x86-64-v4")]])

}  // namespace

Simd best_simd() {
  if (__builtin_cpu_supports("x86-64-v4")) return Simd::kAvx512;
  return __builtin_cpu_supports("avx2") ? Simd::kAvx2 : Simd::kBaseline;
}

const SplineKernels& spline_kernels(Simd simd) {
  switch (simd) {
    case Simd::kAvx512:
      return kKernels_avx512;
    case Simd::kAvx2:
      return kKernels_avx2;
    case Simd::kBaseline:
      break;
  }
  return kKernels_baseline;
}

Float4 spline_weights(float f) { return weights_at(f); }

}  // namespace infuse::dependence
