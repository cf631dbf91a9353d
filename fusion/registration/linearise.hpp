#pragma once

#include <algorithm>
#include <array>
#include <cstring>

#include "drivers/measurement/simd.hpp"
#include "fusion/registration/factors.hpp"
#include "fusion/registration/pose_system.hpp"

namespace infuse::registration {

/// Loads 16 numbers of a field.
[[gnu::always_inline]] inline Floats load(const Pairs::Field& field, size_t i) {
  Floats v;
  std::memcpy(&v, field.data() + i, sizeof(v));
  return v;
}

/// Adds the factor of the pairs i … i + 15.
template <class Factor>
[[gnu::always_inline]] inline void add_pairs(const Pairs& pairs, size_t i, const Factor& factor,
                                             std::array<Floats, kPoseSums>& sums) {
  constexpr int kDirections = Factor::kDirections;
  const Pair<Floats> pair{{load(pairs.px, i), load(pairs.py, i), load(pairs.pz, i)},
                          {load(pairs.sx, i), load(pairs.sy, i), load(pairs.sz, i)},
                          {load(pairs.qx, i), load(pairs.qy, i), load(pairs.qz, i)},
                          {load(pairs.tx, i), load(pairs.ty, i), load(pairs.tz, i)}};
  const LaneVector& p = pair.p;
  const LaneVector r = factor.residual(pair);
  const Information<Floats, kDirections> W = factor.information(pair);
  LaneVector side[kDirections];  // W = Σ side directionᵀ + kIsotropic · 1
  LaneVector Wr{};
#pragma GCC unroll 3
  for (int k = 0; k < kDirections; ++k) {
    side[k] = (W.coefficient[k][0] * W.scale) * W.direction[0];
#pragma GCC unroll 3
    for (int l = 1; l < kDirections; ++l) {
      side[k] = side[k] + (W.coefficient[k][l] * W.scale) * W.direction[l];
    }
    const LaneVector part = dot(W.direction[k], r) * side[k];
    Wr = k == 0 ? part : Wr + part;
  }
  if constexpr (Factor::kIsotropic != 0) {
    Wr = Wr + (Floats{} + static_cast<float>(Factor::kIsotropic)) * r;
  }
  const Floats square = dot(r, Wr);
  const Floats w = load(pairs.weight, i) * factor.weight(square);
  Wr = w * Wr;

  Floats u[kDirections][6], a[kDirections][6];
#pragma GCC unroll 3
  for (int k = 0; k < kDirections; ++k) {
    const LaneVector& n = W.direction[k];
    const LaneVector v = w * side[k], pv = cross(p, v), pn = cross(p, n);
    u[k][0] = pv.x, u[k][1] = pv.y, u[k][2] = pv.z, u[k][3] = v.x, u[k][4] = v.y, u[k][5] = v.z;
    a[k][0] = pn.x, a[k][1] = pn.y, a[k][2] = pn.z, a[k][3] = n.x, a[k][4] = n.y, a[k][5] = n.z;
  }
  size_t e = 0;
#pragma GCC unroll 6
  for (int row = 0; row < 6; ++row) {
#pragma GCC unroll 6
    for (int column = row; column < 6; ++column) {
      Floats product = u[0][row] * a[0][column];
#pragma GCC unroll 3
      for (int k = 1; k < kDirections; ++k) product += u[k][row] * a[k][column];
      sums[e++] += product;
    }
  }
  const LaneVector pWr = cross(p, Wr);
  const Floats rest[] = {pWr.x,         pWr.y,         pWr.z,         Wr.x,
                         Wr.y,          Wr.z,          w * square,    w,
                         w * p.x,       w * p.y,       w * p.z,       w * p.x * p.x,
                         w * p.x * p.y, w * p.x * p.z, w * p.y * p.y, w * p.y * p.z,
                         w * p.z * p.z};
#pragma GCC unroll 17
  for (const Floats& value : rest) sums[e++] += value;
}

template <class Factor>
INFUSE_SIMD_CLONES void add_block(const Pairs& pairs, size_t from, size_t to, const Factor& factor,
                                  std::array<Floats, kPoseSums>& out) {
  std::array<Floats, kPoseSums> sums = {};
  const Factor local = factor;
  for (size_t i = from; i < to; i += kLanes) add_pairs(pairs, i, local, sums);
  out = sums;
}

/// Sums the normal equations of a factor (`factors.hpp`) over all pairs. Same bytes on every
/// processor.
template <class Factor>
PoseSystem linearise(const Pairs& pairs, const Factor& factor) {
  constexpr size_t kBlock = 64 * kLanes;  // pairs summed in single precision
  std::array<double, kPoseSums> total{};
  for (size_t from = 0; from < pairs.padded(); from += kBlock) {
    std::array<Floats, kPoseSums> sums;
    add_block(pairs, from, std::min(from + kBlock, pairs.padded()), factor, sums);
    for (size_t e = 0; e < kPoseSums; ++e) {
      for (int lane = 0; lane < kLanes; ++lane) total[e] += sums[e][lane];
    }
  }
  return pose_system(total, Factor::kIsotropic);
}

}  // namespace infuse::registration
