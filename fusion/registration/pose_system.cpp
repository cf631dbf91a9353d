#include "fusion/registration/pose_system.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "drivers/measurement/simd.hpp"
#include "fusion/registration/point_cloud.hpp"

namespace infuse::registration {
namespace {

constexpr int kTriangle = 21;              // entries of an upper triangle of 6 × 6
constexpr int kSums = kTriangle + 6 + 11;  // planes, gradient, cost, weight, moments of p
constexpr size_t kBlock = 64;              // vectors summed in single precision
using Sums = std::array<Floats, kSums>;

[[gnu::always_inline]] inline Floats load(const Pairs::Field& field, size_t i) {
  Floats v;
  std::memcpy(&v, field.data() + i, sizeof(v));
  return v;
}

/// Adds 16 pairs. `tilt` is a = 1 − ε: a local covariance is 1 − a n nᵀ, and
/// (2 − a (n₁n₁ᵀ + n₂n₂ᵀ))⁻¹ = ½ + ½ a N (2 − a NᵀN)⁻¹ Nᵀ with N = (n₁ n₂).
[[gnu::always_inline]] inline void add_pairs(const Pairs& pairs, size_t i, float tilt, float width2,
                                             Sums& sums) {
  const Floats px = load(pairs.px, i), py = load(pairs.py, i), pz = load(pairs.pz, i);
  const Floats n1x = load(pairs.tx, i), n1y = load(pairs.ty, i), n1z = load(pairs.tz, i);
  const Floats n2x = load(pairs.sx, i), n2y = load(pairs.sy, i), n2z = load(pairs.sz, i);
  const Floats rx = load(pairs.qx, i) - px, ry = load(pairs.qy, i) - py,
               rz = load(pairs.qz, i) - pz;
  const Floats m1 = 2 - tilt * (n1x * n1x + n1y * n1y + n1z * n1z);
  const Floats m2 = 2 - tilt * (n2x * n2x + n2y * n2y + n2z * n2z);
  const Floats m12 = tilt * (n1x * n2x + n1y * n2y + n1z * n2z);
  const Floats scale = 0.5F * tilt / (m1 * m2 - m12 * m12);
  const Floats k1 = m2 * scale, k2 = m1 * scale, k12 = m12 * scale;
  Floats ux = k1 * n1x + k12 * n2x, uy = k1 * n1y + k12 * n2y, uz = k1 * n1z + k12 * n2z;
  Floats vx = k12 * n1x + k2 * n2x, vy = k12 * n1y + k2 * n2y, vz = k12 * n1z + k2 * n2z;
  const Floats d1 = n1x * rx + n1y * ry + n1z * rz;
  const Floats d2 = n2x * rx + n2y * ry + n2z * rz;
  Floats wrx = ux * d1 + vx * d2 + 0.5F * rx;
  Floats wry = uy * d1 + vy * d2 + 0.5F * ry;
  Floats wrz = uz * d1 + vz * d2 + 0.5F * rz;
  const Floats square = rx * wrx + ry * wry + rz * wrz;
  Floats w = load(pairs.weight, i);
  if (width2 > 0) {
    const Floats kernel = width2 / (width2 + square);
    w *= kernel * kernel;
  }
  ux *= w, uy *= w, uz *= w, vx *= w, vy *= w, vz *= w;
  wrx *= w, wry *= w, wrz *= w;

  const Floats u[6] = {py * uz - pz * uy, pz * ux - px * uz, px * uy - py * ux, ux, uy, uz};
  const Floats v[6] = {py * vz - pz * vy, pz * vx - px * vz, px * vy - py * vx, vx, vy, vz};
  const Floats a[6] = {
      py * n1z - pz * n1y, pz * n1x - px * n1z, px * n1y - py * n1x, n1x, n1y, n1z};
  const Floats b[6] = {
      py * n2z - pz * n2y, pz * n2x - px * n2z, px * n2y - py * n2x, n2x, n2y, n2z};
  size_t e = 0;
#pragma GCC unroll 6
  for (int r = 0; r < 6; ++r) {
#pragma GCC unroll 6
    for (int c = r; c < 6; ++c) sums[e++] += u[r] * a[c] + v[r] * b[c];
  }
  sums[e++] += py * wrz - pz * wry;
  sums[e++] += pz * wrx - px * wrz;
  sums[e++] += px * wry - py * wrx;
  sums[e++] += wrx;
  sums[e++] += wry;
  sums[e++] += wrz;
  sums[e++] += w * square;
  sums[e++] += w;
  sums[e++] += w * px;
  sums[e++] += w * py;
  sums[e++] += w * pz;
  sums[e++] += w * px * px;
  sums[e++] += w * px * py;
  sums[e++] += w * px * pz;
  sums[e++] += w * py * py;
  sums[e++] += w * py * pz;
  sums[e++] += w * pz * pz;
}

INFUSE_SIMD_CLONES void add_block(const Pairs& pairs, size_t from, size_t to, float tilt,
                                  float width2, Sums& out) {
  Sums sums = {};
  for (size_t i = from; i < to; i += kLanes) add_pairs(pairs, i, tilt, width2, sums);
  out = sums;
}

}  // namespace

void Pairs::resize(size_t pairs) {
  size = pairs;
  for (Field* field :
       {&px, &py, &pz, &sx, &sy, &sz, &qx, &qy, &qz, &tx, &ty, &tz, &weight, &tilt}) {
    reserve_with_headroom(*field, padded());
    field->resize(padded());
    std::fill(field->begin() + static_cast<ptrdiff_t>(pairs), field->end(), 0.0F);
  }
  std::fill(tilt.begin(), tilt.end(), 0.0F);
}

PoseSystem pose_system(const Pairs& pairs, const PairNoise& noise) {
  const auto tilt = static_cast<float>(1 - noise.plane_variance);
  // The kernel's width, in units of the weighted square: rᵀWr is d² / 2ε at distance d.
  const auto width2 =
      static_cast<float>(noise.robust_width * noise.robust_width / (2 * noise.plane_variance));
  std::array<double, kSums> total{};
  for (size_t from = 0; from < pairs.padded(); from += kBlock * kLanes) {
    Sums sums;
    add_block(pairs, from, std::min(from + kBlock * kLanes, pairs.padded()), tilt, width2, sums);
    for (size_t e = 0; e < kSums; ++e) {
      for (int lane = 0; lane < kLanes; ++lane) total[e] += sums[e][lane];
    }
  }
  PoseSystem system;
  size_t e = 0;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) system.planes(r, c) = system.planes(c, r) = total[e++];
  }
  for (int r = 0; r < 6; ++r) system.gradient[r] = total[e++];
  system.cost = total[e++];
  system.weight = total[e++];
  if (!(system.weight > 0)) return system;
  const Eigen::Vector3d first(total[e], total[e + 1], total[e + 2]);
  Eigen::Matrix3d second;
  second << total[e + 3], total[e + 4], total[e + 5], total[e + 4], total[e + 6], total[e + 7],
      total[e + 5], total[e + 7], total[e + 8];
  system.mean = first / system.weight;
  system.radius =
      std::sqrt(std::max(second.trace() / system.weight - system.mean.squaredNorm(), 0.0));
  system.isotropic.topLeftCorner<3, 3>() =
      0.5 * (second.trace() * Eigen::Matrix3d::Identity() - second);
  system.isotropic.topRightCorner<3, 3>() = 0.5 * geometry::skew(first);
  system.isotropic.bottomLeftCorner<3, 3>() = -0.5 * geometry::skew(first);
  system.isotropic.bottomRightCorner<3, 3>() = 0.5 * system.weight * Eigen::Matrix3d::Identity();
  return system;
}

}  // namespace infuse::registration
